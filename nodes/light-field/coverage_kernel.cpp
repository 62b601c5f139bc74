// Decides which surfaces are seen from a location.
#include <algorithm>
#include <cmath>

#include "light-field/surrounded.h"

namespace weft::light_field::WEFT_ISA {
namespace {

// Whether a surface of a location surrounds it.
bool surrounds(const Candidates& c, const Surfaces& s, size_t l, std::uint16_t surface, float radius, CoverageScratch& scratch) {
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
            const auto of_it = hn::And(surface_among(&s.surface[i], surface, surface), hn::FirstN(f, end - i));
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

void cover(const Candidates& c, const Surfaces& s, float radius, Visibility& out) {
    const size_t n = c.size();
    out.clear(n);
    const float enough = thin_near * samples_in(radius, *c.hierarchy);
    for (size_t l = 0; l < n; ++l) {
        const std::uint16_t surfaces = s.count_of[l];
        Decision decision = surfaces == 1 ? Decision::one : Decision::undecided;
        if (surfaces > 1) {
            Hull hull;
            size_t near = 0;
            const float own = radius * c.ratio_of(l);
            const VF limit = hn::Set(f, own * own);
            const size_t begin = c.offset[l], end = c.offset[l + 1];
            for (size_t i = begin; i < end; i += lanes) {
                const VF dx = hn::LoadU(f, &c.dx[i]), dy = hn::LoadU(f, &c.dy[i]);
                const auto front = hn::And(surface_among(&s.surface[i], 0, 0), hn::FirstN(f, end - i));
                hull.add(dx, dy, front);
                near += hn::CountTrue(f, hn::And(front, hn::Lt(hn::MulAdd(dx, dx, hn::Mul(dy, dy)), limit)));
            }
            if (float(near) >= enough && hull.inside()) decision = Decision::covered;
        }
        out.decision[l] = decision;
    }
}

void cover_finally(const Candidates& c, const Surfaces& s, float radius, CoverageScratch& scratch, Visibility& out) {
    const size_t n = c.size();
    out.clear(n);
    const float thin = thin_around * samples_in(2 * radius, *c.hierarchy);
    const float whole = squared_tent_mean * samples_in(radius, *c.hierarchy);
    for (size_t l = 0; l < n; ++l) {
        const std::uint16_t surfaces = s.count_of[l];
        if (surfaces < 2) {
            out.decision[l] = surfaces ? Decision::one : Decision::undecided;
            continue;
        }
        const float own = radius * c.ratio_of(l);
        scratch.sizes.assign(surfaces, 0);
        scratch.weights.assign(surfaces, 0);
        for (size_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
            const float d2 = c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i];
            if (d2 < 4 * own * own) ++scratch.sizes[s.surface[i]];
            if (d2 >= own * own) continue;
            const float tent = 1 - std::sqrt(d2) / own;
            scratch.weights[s.surface[i]] += tent * tent;
        }
        float left = 1;
        const size_t first = out.parts.size();
        for (std::uint16_t at = 0; at < surfaces && left > 0; ++at) {
            float share = left;
            if (at + 1 < surfaces) {
                if (float(scratch.sizes[at]) < thin) share *= std::min(1.0f, scratch.weights[at] / whole);
                else if (!surrounds(c, s, l, at, own, scratch)) share = 0;
            }
            if (share <= 0) continue;
            out.parts.push_back({std::uint32_t(l), at, share});
            left -= share;
        }
        out.decision[l] = Decision::partly;
        if (out.parts.size() > first + 1) continue;
        const std::uint16_t seen = out.parts.back().surface;
        out.parts.pop_back();
        out.first[l] = out.last[l] = seen;
        out.decision[l] = seen + 1 == surfaces ? Decision::last : Decision::covered;
    }
}

}  // namespace weft::light_field::WEFT_ISA
