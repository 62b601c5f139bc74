// Decides which surfaces are seen from a location.
#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {
namespace {

// Ratios dx / dy of points on the one and on the other side of the horizontal line through the
// location. It lies in the hull of all where segments across the line pass it on both sides.
struct Hull {
    VF lowest_below = hn::Set(f, 1e38f), highest_below = hn::Set(f, -1e38f);
    VF lowest_above = hn::Set(f, 1e38f), highest_above = hn::Set(f, -1e38f);

    template <class M>
    void add(VF dx, VF dy, M valid) {
        const VF zero = hn::Zero(f), big = hn::Set(f, 1e38f), small = hn::Set(f, -1e38f);
        const VF ratio = hn::Max(small, hn::Min(big, hn::Div(dx, dy)));
        const auto below = hn::And(hn::Ge(dy, zero), valid), above = hn::And(hn::Lt(dy, zero), valid);
        lowest_below = hn::Min(lowest_below, hn::IfThenElse(below, ratio, big));
        highest_below = hn::Max(highest_below, hn::IfThenElse(below, ratio, small));
        lowest_above = hn::Min(lowest_above, hn::IfThenElse(above, ratio, big));
        highest_above = hn::Max(highest_above, hn::IfThenElse(above, ratio, small));
    }
    bool inside() const {
        return hn::GetLane(hn::MaxOfLanes(f, highest_below)) > hn::GetLane(hn::MinOfLanes(f, lowest_above)) &&
               hn::GetLane(hn::MinOfLanes(f, lowest_below)) < hn::GetLane(hn::MaxOfLanes(f, highest_above));
    }
};

// Whether a triangle of the points, edges at most 2 radius long and a corner within radius, holds
// the origin. Points within `radius` come first: `near` of them, `n` in all.
bool triangle(const float* x, const float* y, size_t near, size_t n, float radius, CoverageScratch& scratch) {
    const float longest = 4 * radius * radius;
    const size_t room = n + lanes;
    for (auto* values : {&scratch.left_x, &scratch.left_y, &scratch.right_x, &scratch.right_y})
        if (values->size() < room) values->resize(2 * room);
    const VF zero = hn::Zero(f), limit = hn::Set(f, longest);
    for (size_t i = 0; i < near; ++i) {
        // The others by the side of the line through i and the origin on which they lie.
        size_t lefts = 0, rights = 0;
        const VF px = hn::Set(f, x[i]), py = hn::Set(f, y[i]);
        for (size_t j = 0; j < n; j += lanes) {
            const VF qx = hn::LoadU(f, x + j), qy = hn::LoadU(f, y + j);
            const VF ex = hn::Sub(qx, px), ey = hn::Sub(qy, py), side = hn::NegMulAdd(py, qx, hn::Mul(px, qy));
            auto close = hn::And(hn::Le(hn::MulAdd(ex, ex, hn::Mul(ey, ey)), limit), hn::FirstN(f, n - j));
            if (j <= i && i < j + lanes) close = hn::AndNot(hn::RebindMask(f, hn::Eq(hn::Iota(sn, std::int32_t(j)), hn::Set(sn, std::int32_t(i)))), close);
            const Pack left(hn::And(close, hn::Ge(side, zero))), right(hn::And(close, hn::Le(side, zero)));
            left.store(qx, &scratch.left_x[lefts]);
            left.store(qy, &scratch.left_y[lefts]);
            right.store(qx, &scratch.right_x[rights]);
            right.store(qy, &scratch.right_y[rights]);
            lefts += left.count;
            rights += right.count;
        }
        for (size_t j = 0; j < lefts; ++j) {
            const VF lx = hn::Set(f, scratch.left_x[j]), ly = hn::Set(f, scratch.left_y[j]);
            for (size_t k = 0; k < rights; k += lanes) {
                const VF rx = hn::LoadU(f, &scratch.right_x[k]), ry = hn::LoadU(f, &scratch.right_y[k]);
                const VF ex = hn::Sub(rx, lx), ey = hn::Sub(ry, ly);
                const auto turns = hn::Ge(hn::NegMulAdd(ly, rx, hn::Mul(lx, ry)), zero);
                const auto near_enough = hn::Le(hn::MulAdd(ex, ex, hn::Mul(ey, ey)), limit);
                const auto holds = hn::And(hn::And(turns, near_enough), hn::FirstN(f, rights - k));
                if (!hn::AllFalse(f, holds)) return true;
            }
        }
    }
    return false;
}

// Whether the surfaces [first, last] of a location surround it (triangle() has the rule).
bool surrounds(const Candidates& c, const Surfaces& s, size_t l, std::uint16_t first, std::uint16_t last,
               float radius, CoverageScratch& scratch) {
    constexpr size_t enough = 200;  // points in such a crowd surround what their hull does
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
    if (n < 3) return false;
    if (near == 0) return false;
    Hull hull;
    for (size_t i = 0; i < n; i += lanes) hull.add(hn::LoadU(f, x + i), hn::LoadU(f, y + i), hn::FirstN(f, n - i));
    if (!hull.inside()) return false;
    if (n > enough) return true;
    Hull inner;
    for (size_t i = 0; i < near; i += lanes)
        inner.add(hn::LoadU(f, x + i), hn::LoadU(f, y + i), hn::FirstN(f, near - i));
    // A hull of points within `radius` is made of triangles that keep the rule.
    if (inner.inside()) return true;
    return triangle(x, y, near, n, radius, scratch);
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
            if (last || surrounds(c, s, l, first, at, radius, scratch)) {
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
