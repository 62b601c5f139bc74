// Which groups of a block may have samples in a rectangle at one (u, v, t). For kernels (weft_kernels).
#pragma once
#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {

struct GroupTest {
    VF lens_x, lens_y, time, left, right, top, bottom;

    // d = t - 1/2; the rectangle is [x0, x1] x [y0, y1].
    GroupTest(const Hierarchy& h, float u, float v, float d, float x0, float x1, float y0, float y1)
        : lens_x(hn::Set(f, u * h.lens.aspect)), lens_y(hn::Set(f, v)), time(hn::Set(f, d)),
          left(hn::Set(f, x0)), right(hn::Set(f, x1)), top(hn::Set(f, y0)), bottom(hn::Set(f, y1)) {}

    struct Bounds {
        VF left, right, top, bottom;
    };
    // Of groups i, i + 1, ...
    HWY_INLINE Bounds bounds(const Block& block, size_t i) const {
        const VF slope = hn::LoadU(f, &block.slope[i]);
        const VF x = hn::MulAdd(slope, lens_x, hn::Mul(hn::LoadU(f, &block.velocity_x[i]), time));
        const VF y = hn::MulAdd(slope, lens_y, hn::Mul(hn::LoadU(f, &block.velocity_y[i]), time));
        return {hn::Add(hn::LoadU(f, &block.x_low[i]), x), hn::Add(hn::LoadU(f, &block.x_high[i]), x),
                hn::Add(hn::LoadU(f, &block.y_low[i]), y), hn::Add(hn::LoadU(f, &block.y_high[i]), y)};
    }
    HWY_INLINE auto operator()(const Block& block, size_t i) const {
        const Bounds at = bounds(block, i);
        return hn::And(hn::And(hn::Le(at.left, right), hn::Ge(at.right, left)),
                       hn::And(hn::Le(at.top, bottom), hn::Ge(at.bottom, top)));
    }
};

}  // namespace weft::light_field::WEFT_ISA
