// Which samples are nearest to places by their own metrics: places are the lanes of a vector, and
// samples that may count at any of them are looked at one after another.
// Source: Hachisuka et al. 2008, Sec. 5 (the sample of least distance decides).
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "adaptive/adaptive_tree.h"
#include "runtime/isa.h"

namespace weft::adaptive {

// Samples that may count in some box: each within the square root of its `support2`.
struct NearbySamples {
    std::array<std::vector<float>, most_axes> at;  // px
    std::vector<float> support2;
    std::vector<std::uint32_t> place;  // in the tree's order, ascending
    size_t axes = 0, size = 0;         // arrays are longer by a vector, which counts nowhere
};

// Those that do count somewhere in a smaller box: of each support2, where it is, and its metric by
// rows, what is not on the diagonal twice. Where the box is a slice, of x and y alone, records are of
// that: what is left of support2 there, x, y, and the distance's square as a polynomial in dx and dy,
// by dx, dx dx, dx dy, dy, dy dy and 1.
struct CountingSamples {
    std::vector<float> records;
    std::vector<std::uint32_t> place;
    bool slice = false;
};

// Where radiance is asked for, px. Arrays are as long as whole vectors of 16; pad() repeats the
// last place.
struct Places {
    std::array<std::vector<float>, most_axes> at;
    size_t axes = 0, size = 0;
    void start(size_t dimensions, size_t count) {
        axes = dimensions, size = count;
        for (size_t d = 0; d < axes; ++d) at[d].resize((count + 15) / 16 * 16);
    }
    void pad() {
        for (size_t d = 0; d < axes; ++d)
            for (size_t i = size; i < at[d].size(); ++i) at[d][i] = at[d][size - 1];
    }
    void bounds(float* lo, float* hi) const {
        for (size_t d = 0; d < axes; ++d) {
            const auto [least, most] =
                std::minmax_element(at[d].begin(), at[d].begin() + std::ptrdiff_t(size));
            lo[d] = *least, hi[d] = *most;
        }
    }
};

// Of each place the four samples of least distance of those that count there, nearest first.
struct NearestSamples {
    static constexpr size_t most = 4;
    static constexpr float none = std::numeric_limits<float>::infinity();
    std::array<std::vector<float>, most> distance2;       // by metric; `none` where fewer count
    std::array<std::vector<std::uint32_t>, most> sample;  // index into the CountingSamples
};

//   find_counting      those of `nearby` that count somewhere between lo and hi; `upper`: metrics
//   in
//                      the tree's order
//   nearest_by_metric  of equal ones the first; padding of `places` is looked at, too
#define WEFT_NEAREST_BY_METRIC(isa)                                                      \
    namespace isa {                                                                      \
    void find_counting(const NearbySamples& nearby, const float* upper, const float* lo, \
                       const float* hi, CountingSamples& found);                         \
    void nearest_by_metric(const CountingSamples& samples, const Places& places,         \
                           NearestSamples& nearest);                                     \
    }
WEFT_NEAREST_BY_METRIC(v2)
WEFT_NEAREST_BY_METRIC(v3)
WEFT_NEAREST_BY_METRIC(v4)
#undef WEFT_NEAREST_BY_METRIC

}  // namespace weft::adaptive
