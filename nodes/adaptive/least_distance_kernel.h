// Which of the samples near a place is nearest by its own metric.
//   Samples are brought to the place's lens position, time and light once for many places: what is
//   left of each is a quadratic in x and y.
// Source: Hachisuka et al. 2008, Sec. 5 (the sample of least distance decides).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "adaptive/adaptive_tree.h"
#include "runtime/isa.h"

namespace weft::adaptive {

// Samples at common numbers on all axes but x and y. Distance by sample i's metric from (x, y),
// with dx = x - x_i: xx dx^2 + 2 xy dx dy + yy dy^2 + 2 (bx dx + by dy) + rest, and dx^2 + dy^2 +
// off2 in scaled space. Arrays are padded to a multiple of 16 with samples that are nowhere.
struct NearSamples {
    std::vector<float> x, y, off2, xx, xy, yy, bx, by, rest;
    std::vector<std::uint32_t> place;  // in the tree's order, ascending
    size_t size = 0;                   // without padding
    void clear();
    void pad();
};

// Scratch: squared distances, and the metric's as whole numbers, which are in the same order.
struct LeastDistance {
    std::vector<float> distance2;
    std::vector<std::int32_t> by_metric;
};

inline constexpr std::int32_t not_known = -1;

// Of the `candidates` samples nearest to (x, y) in scaled space, the one of least distance by its
// own metric: its index in `near`. not_known where fewer of them lie within the square root of
// `reach2`, beyond which samples may be missing in `near`. Of equals the first.
#define WEFT_LEAST_DISTANCE(isa)                                                                \
    namespace isa {                                                                             \
    std::int32_t least_distance(const NearSamples& near, float x, float y,                      \
                                std::int32_t candidates, float reach2, LeastDistance& scratch); \
    }
WEFT_LEAST_DISTANCE(v2)
WEFT_LEAST_DISTANCE(v3)
WEFT_LEAST_DISTANCE(v4)
#undef WEFT_LEAST_DISTANCE

}  // namespace weft::adaptive
