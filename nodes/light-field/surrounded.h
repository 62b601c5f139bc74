// Whether samples of a surface surround a location, which stands at the origin: some triangle of
// them holds it, of edges at most 2 radius long and with a corner within radius. For kernels
// (weft_kernels).
#pragma once
#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {

// Ratios dx / dy of points on the one and on the other side of the horizontal line through the
// location. It lies in the hull of all where segments across the line pass it on both sides.
struct Hull {
    VF lowest_below = hn::Set(f, 1e38f), highest_below = hn::Set(f, -1e38f);
    VF lowest_above = hn::Set(f, 1e38f), highest_above = hn::Set(f, -1e38f);

    template <class M>
    HWY_INLINE void add(VF dx, VF dy, M valid) {
        const VF zero = hn::Zero(f), big = hn::Set(f, 1e38f), small = hn::Set(f, -1e38f);
        const VF ratio = hn::Max(small, hn::Min(big, hn::Div(dx, dy)));
        const auto below = hn::And(hn::Ge(dy, zero), valid),
                   above = hn::And(hn::Lt(dy, zero), valid);
        lowest_below = hn::Min(lowest_below, hn::IfThenElse(below, ratio, big));
        highest_below = hn::Max(highest_below, hn::IfThenElse(below, ratio, small));
        lowest_above = hn::Min(lowest_above, hn::IfThenElse(above, ratio, big));
        highest_above = hn::Max(highest_above, hn::IfThenElse(above, ratio, small));
    }
    HWY_INLINE bool inside() const {
        return hn::GetLane(hn::MaxOfLanes(f, highest_below)) >
                   hn::GetLane(hn::MinOfLanes(f, lowest_above)) &&
               hn::GetLane(hn::MinOfLanes(f, lowest_below)) <
                   hn::GetLane(hn::MaxOfLanes(f, highest_above));
    }
};

// Whether a triangle of the points holds the origin, by the rule above. Points within `radius` come
// first: `near` of them, `n` in all.
inline bool triangle(const float* x, const float* y, size_t near, size_t n, float radius,
                     CoverageScratch& scratch) {
    const size_t room = n + lanes;
    for (auto* values : {&scratch.left_x, &scratch.left_y, &scratch.right_x, &scratch.right_y})
        if (values->size() < room) values->resize(2 * room);
    const VF zero = hn::Zero(f), limit = hn::Set(f, 4 * radius * radius);
    // Triangles whose first near corner is i.
    for (size_t i = 0; i < near; ++i) {
        // The other corners by the side of the line through i and the origin on which they lie.
        size_t lefts = 0, rights = 0;
        const VF px = hn::Set(f, x[i]), py = hn::Set(f, y[i]);
        Hull hull;
        for (size_t j = i / lanes * lanes; j < n; j += lanes) {
            const VF qx = hn::LoadU(f, x + j), qy = hn::LoadU(f, y + j);
            const VF ex = hn::Sub(qx, px), ey = hn::Sub(qy, py),
                     side = hn::NegMulAdd(py, qx, hn::Mul(px, qy));
            auto close =
                hn::And(hn::Le(hn::MulAdd(ex, ex, hn::Mul(ey, ey)), limit), hn::FirstN(f, n - j));
            if (j < i) close = hn::AndNot(hn::FirstN(f, i - j), close);
            hull.add(qx, qy, close);
            if (j <= i) close = hn::AndNot(hn::FirstN(f, i + 1 - j), close);
            const Pack left(hn::And(close, hn::Ge(side, zero))),
                right(hn::And(close, hn::Le(side, zero)));
            left.store(qx, &scratch.left_x[lefts]);
            left.store(qy, &scratch.left_y[lefts]);
            right.store(qx, &scratch.right_x[rights]);
            right.store(qy, &scratch.right_y[rights]);
            lefts += left.count;
            rights += right.count;
        }
        if (lefts == 0 || rights == 0 || !hull.inside()) continue;
        for (size_t j = 0; j < lefts; ++j) {
            const VF lx = hn::Set(f, scratch.left_x[j]), ly = hn::Set(f, scratch.left_y[j]);
            for (size_t k = 0; k < rights; k += lanes) {
                const VF rx = hn::LoadU(f, &scratch.right_x[k]),
                         ry = hn::LoadU(f, &scratch.right_y[k]);
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

// Points as for triangle().
inline bool surrounded(const float* x, const float* y, size_t near, size_t n, float radius,
                       CoverageScratch& scratch) {
    constexpr size_t enough = 200;  // points in such a crowd surround what their hull does
    if (n < 3 || near == 0) return false;
    Hull hull;
    for (size_t i = 0; i < n; i += lanes)
        hull.add(hn::LoadU(f, x + i), hn::LoadU(f, y + i), hn::FirstN(f, n - i));
    if (!hull.inside()) return false;
    if (n > enough) return true;
    Hull inner;
    for (size_t i = 0; i < near; i += lanes)
        inner.add(hn::LoadU(f, x + i), hn::LoadU(f, y + i), hn::FirstN(f, near - i));
    // A hull of points within `radius` is made of triangles that keep the rule.
    if (inner.inside()) return true;
    return triangle(x, y, near, n, radius, scratch);
}

}  // namespace weft::light_field::WEFT_ISA
