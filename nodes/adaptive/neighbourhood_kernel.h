// Neighbourhoods of samples by distances of their own, and what is fitted to them: one sample after
// another of a bucket of the tree, among those around the bucket and then around itself, a vector
// at once.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "adaptive/adaptive_tree.h"
#include "runtime/isa.h"

namespace weft::adaptive {

// The samples around a bucket, or around one sample, padded to a multiple of 16 with ones that are
// nowhere.
struct SamplesAround {
    std::array<std::vector<float>, most_axes> at;  // px
    std::vector<std::uint32_t> place;              // in the tree's order
    size_t size = 0;                               // without padding
};

// Numbers of a sample that are averaged: D (D + 1) / 2 of a tensor and two more. And from one
// sample's to the next one's, in whole vectors.
constexpr size_t averaged_numbers(size_t axes) {
    return axes * (axes + 1) / 2 + 2;
}
constexpr size_t averaged_stride(size_t axes) {
    return (averaged_numbers(axes) + 7) / 8 * 8;
}

// A sample's neighbours, itself among them.
struct Neighbourhood {
    std::vector<float> distance2;       // of all around it
    std::vector<std::uint32_t> near;    // which of these are neighbours
    std::vector<float> weight;          // of each neighbour: exp(-2 d^2 / r^2)
    std::vector<float> offset, change;  // scratch
    float radius2 = 0;                  // r^2: none is farther
    float guess = 0;                    // for the next one's radius
};

// Sums over a neighbourhood, with d the offset from the sample and f a channel's difference to it:
// w, w d, w f, w d d^T (upper triangle by rows), w d f (channel by channel).
struct NeighbourSums {
    float w = 0;
    std::array<float, most_axes> d{};
    std::array<float, 3> f{};
    std::array<float, most_axes*(most_axes + 1) / 2> dd{};
    std::array<float, 3 * most_axes> df{};
    std::array<float, 3> least{}, most{};  // of the channels' values
};

#define WEFT_NEIGHBOURHOOD(isa)                                                                    \
    namespace isa {                                                                                \
    /* Takes in, of samples [begin, end), those that are within the square root of `reach2` of  */ \
    /* the box from lo to hi. `place`: what they are called; null: by their index.              */ \
    void append_within(const std::array<const float*, most_axes>& at, const std::uint32_t* place,  \
                       size_t begin, size_t end, size_t axes, const float* lo, const float* hi,    \
                       float reach2, SamplesAround& to);                                           \
    /* Finds about `count` nearest, never fewer, of those within the square root of `within2`:  */ \
    /* by the metric `upper`, or Euclidean where it is null. False where there are too few.     */ \
    bool find_neighbours(const SamplesAround& around, size_t axes, const float* centre,            \
                         const float* upper, float within2, size_t count, Neighbourhood& found);   \
    /* `rgb`: three arrays in the tree's order; `self`: the sample's place in it.               */ \
    NeighbourSums sum_neighbours(const SamplesAround& around, size_t axes, const float* centre,    \
                                 const std::array<const float*, 3>& rgb, std::uint32_t self,       \
                                 Neighbourhood& of);                                               \
    /* Weighted mean of each of averaged_numbers.                                               */ \
    void mean_of_neighbours(const SamplesAround& around, const float* values, size_t axes,         \
                            const Neighbourhood& of, float* mean);                                 \
    }
WEFT_NEIGHBOURHOOD(v2)
WEFT_NEIGHBOURHOOD(v3)
WEFT_NEIGHBOURHOOD(v4)
#undef WEFT_NEIGHBOURHOOD

}  // namespace weft::adaptive
