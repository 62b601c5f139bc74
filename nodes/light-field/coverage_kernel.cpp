// Decides which surfaces are seen from a location.
#include <algorithm>
#include <cmath>

#include "light-field/surrounded.h"

namespace weft::light_field::WEFT_ISA {
namespace {

// Whether the surfaces [first, last] of a location surround it.
bool surrounds(const Candidates& c, const Surfaces& s, size_t l, std::uint16_t first, std::uint16_t last,
               float radius, CoverageScratch& scratch) {
    const size_t begin = c.offset[l], end = c.offset[l + 1];
    if (scratch.x.size() < end - begin + 2 * lanes) {
        scratch.x.resize(2 * (end - begin + 2 * lanes));
        scratch.y.resize(2 * (end - begin + 2 * lanes));
    }
    // Those within the radius first.
    size_t near = 0, n = 0;
    const VF limit = hn::Set(f, radius * radius);
    float *x = scratch.x.data(), *y = scratch.y.data();
    for (const bool inside : {true, false}) {
        for (size_t i = begin; i < end; i += lanes) {
            const VF dx = hn::LoadU(f, &c.dx[i]), dy = hn::LoadU(f, &c.dy[i]);
            const auto of_it = hn::And(surface_among(&s.surface[i], first, last), hn::FirstN(f, end - i));
            const auto within = hn::Le(hn::MulAdd(dx, dx, hn::Mul(dy, dy)), limit);
            const Pack pack(hn::And(of_it, inside ? within : hn::Not(within)));
            pack.store(dx, x + n);
            pack.store(dy, y + n);
            n += pack.count;
        }
        if (inside) near = n;
    }
    return surrounded(x, y, near, n, radius, scratch);
}

}  // namespace

void cover(const Candidates& c, const Surfaces& s, Visibility& out) {
    const size_t n = c.size();
    out.first.assign(n, 0);
    out.last.assign(n, 0);
    out.decision.resize(n);
    out.weight.clear();
    for (size_t l = 0; l < n; ++l) {
        const std::uint16_t surfaces = s.count_of[l];
        Decision decision = surfaces == 1 ? Decision::one : Decision::undecided;
        if (surfaces > 1) {
            Hull hull;
            const size_t begin = c.offset[l], end = c.offset[l + 1];
            for (size_t i = begin; i < end; i += lanes) {
                const auto front = hn::And(surface_among(&s.surface[i], 0, 0), hn::FirstN(f, end - i));
                hull.add(hn::LoadU(f, &c.dx[i]), hn::LoadU(f, &c.dy[i]), front);
            }
            if (hull.inside()) decision = Decision::covered;
        }
        out.decision[l] = decision;
    }
}

void cover_finally(const Candidates& c, const Surfaces& s, float radius, CoverageScratch& scratch, Visibility& out) {
    constexpr size_t small = 4;  // samples; a surface of fewer is taken together with the one behind it
    const size_t n = c.size();
    out.first.assign(n, 0);
    out.last.assign(n, 0);
    out.decision.resize(n);
    out.weight.clear();
    for (size_t l = 0; l < n; ++l) {
        const std::uint16_t surfaces = s.count_of[l];
        if (surfaces < 2) {
            out.decision[l] = surfaces ? Decision::one : Decision::undecided;
            continue;
        }
        scratch.sizes.assign(surfaces, 0);
        for (size_t i = c.offset[l]; i < c.offset[l + 1]; ++i) ++scratch.sizes[s.surface[i]];
        std::uint16_t first = 0;
        size_t together = 0;
        for (std::uint16_t at = 0; at < surfaces; ++at) {
            together += scratch.sizes[at];
            const bool last = at + 1 == surfaces;
            if (!last && together < small) continue;
            if (last || surrounds(c, s, l, first, at, radius * c.ratio_of(l), scratch)) {
                out.first[l] = first;
                out.last[l] = at;
                out.decision[l] = last ? Decision::last : Decision::covered;
                break;
            }
            first = std::uint16_t(at + 1);
            together = 0;
        }
    }
}

}  // namespace weft::light_field::WEFT_ISA
