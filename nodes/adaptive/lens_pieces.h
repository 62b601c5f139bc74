// A lens cut into columns, each a rectangle: what makes integrals over any outline, round or with
// blades, sums of products of one over u and one over v.
//   columns  of equal width over u in [-1, 1]; each from the mean of the outline's lower ends there
//            to that of its upper ends, so that areas are kept
#pragma once
#include <array>

#include "adaptive/sheared_weights.h"
#include "samples/samples.h"

namespace weft::adaptive {

inline constexpr size_t lens_columns = 16;

// The lens as uv has it: the unit disc or a polygon in it, before aspect.
struct LensPieces {
    explicit LensPieces(const Lens& lens);
    std::array<Interval, lens_columns> v;  // empty where no part of the lens is
    static constexpr float width = 2.0f / lens_columns;
    static Interval column(size_t k) { return {float(k) * width - 1, float(k + 1) * width - 1}; }
    // The columns [first, last] that an interval of u meets.
    static std::array<size_t, 2> columns(Interval u) {
        const auto of = [](float at) {
            return size_t(std::clamp((at + 1) / width, 0.0f, float(lens_columns - 1)));
        };
        return {of(u.a), of(u.b)};
    }
};

}  // namespace weft::adaptive
