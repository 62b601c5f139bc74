// The kernels of random parameter filtering: plain functions over arrays, built for each
// instruction set (WEFT_PICK(accept)(...), runtime/isa.h). What each must give is said by scalar
// forms in tests/rpf/reference_kernels.h. Rows are numbers of the samples of a neighbourhood,
// `pitch` apart, 0 from n to whole vectors. Cost: no allocation once buffers have grown.  Threads:
// each call touches its own outputs only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rpf/bins.h"
#include "rpf/draws.h"
#include "rpf/streams.h"
#include "runtime/isa.h"

namespace weft::rpf {

// How like two samples are: of features and colours apart, squared differences of normalised
// numbers, weighted.
struct Likeness {
    float scale = 1;   // of both sums, before they become exponents: (1 - W_c^r)^2 / (2 sigma^2)
    float cutoff = 6;  // of either exponent: where it is reached the weight is 0
};
struct FilterScratch {
    // A row that counts: numbers less the mean of the own ones, times the root of its weight, are
    // what squared differences between samples are summed up of to exponents of 2.
    struct Row {
        const float* numbers;
        float mean, root;
    };
    std::vector<Row> rows;
    std::vector<float> own, weights;
    std::vector<float> r, g, b;
};
struct LayoutScratch {
    std::vector<float> sums;
};

// How like two pixels are: distances of their means, noise taken off.
//   ((a - b)^2 - (va + min(va, vb))) / (e + k^2 (va + vb))
// of colours the mean of the three, over a patch of 3 x 3 pixels; of features the sum over their
// components, with e from what they change by over `slope` pixels and at least by `least`
// deviations of the picture. Source: Rousselle, Knaus and Zwicker 2012 (the distance), 2013 (of
// features).
struct PixelLikeness {
    int radius = 7;   // px: pixels (2 radius + 1)^2 are compared
    float sigma = 3;  // px, deviation of the spatial Gaussian
    float k_color = 0.5f, k_features = 2, slope = 4, least = 0.02f;

    size_t side() const { return size_t(2 * radius + 1); }
    // Weights lie in rows of offsets dx = -radius ..., this far apart; those past a row's end are
    // 0.
    size_t pitch() const { return (side() + 15) / 16 * 16; }
    size_t size() const { return side() * pitch(); }
};
struct PixelScratch {
    std::vector<float> nearness, distances, known, feature_scale, beta;
};

// Samples of the pixels around one, as rows: weights of their pixels, colours, and those features
// that count, by their factors.
struct AroundScratch {
    std::vector<std::uint32_t> sample;
    std::vector<float> weight, rows, mine;
    std::vector<size_t> components;
};

// What of a kernel is built for each instruction set.
#define WEFT_RPF_KERNELS                                                                           \
    /* Of each pixel from one on its first samples, `counts` of them or as many as there are.      \
     * Writes up to 16 past the end, which it gives. */                                            \
    std::uint32_t* take_first(const Samples& samples, size_t pixel,                                \
                              std::span<const std::uint16_t> counts, std::uint32_t* to);           \
    /* Of each of these any samples, `counts` of them, repeats and all, by chance: numbers are a   \
     * function of it, the pixel and the draw. Writes up to 16 past the end, which it gives. */    \
    std::uint32_t* take_any(const Samples& samples, size_t pixel,                                  \
                            std::span<const std::uint16_t> counts, std::uint32_t chance,           \
                            std::uint32_t* to);                                                    \
    /* Of n pixels from one on which of their samples are near. Reads and writes up to whole       \
     * multiples of 64. */                                                                         \
    void judge_pixels(std::span<const NearCodes> by, size_t pixel, size_t n, PixelNear* to);       \
    /* Of a neighbourhood that so far has a block's own samples: more of them, those drawn whose   \
     * vectors lie within `bound` of `centre` in every component, in order; and the rows of all,   \
     * at a pitch that is set. */                                                                  \
    void take_near(const SampleVectors& vectors, const DrawnSamples& drawn, const float* centre,   \
                   const float* bound, LayoutScratch& scratch, Neighbourhoods& out);               \
    /* Which samples of a row fall into each bin but the last, as bits: columns that lie side by   \
     * side, `pitch` from word to word. */                                                         \
    void sort_into_bins(const float* row, size_t n, const Edges& edges, std::uint64_t* columns,    \
                        size_t pitch);                                                             \
    /* How many bits columns have. Reads and writes up to whole multiples of 8 columns. */         \
    void count_each(const std::uint64_t* bits, size_t columns, size_t pitch, size_t words,         \
                    std::uint32_t* counts);                                                        \
    /* How many bits each of some columns shares with each of others: those of a from one to the   \
     * next of b. Reads and */                                                                     \
    /* writes up to whole multiples of 8 columns of b. */                                          \
    void count_common(const std::uint64_t* a, size_t rows, const std::uint64_t* b, size_t columns, \
                      size_t pitch, size_t words, std::uint32_t* counts, size_t counts_pitch);     \
    /* Colours of a neighbourhood's own samples, filtered from those of all, and of how many. */   \
    void filter(const Neighbourhoods& around, const Weights& weights, const float* rgb,            \
                const Likeness& likeness, FilterScratch& scratch, SampleColors& out);              \
    /* Of each pixel of a block the weights of those around it: block pixels x by.size(). */       \
    void weigh_pixels(const SampleVectors& vectors, PixelBlock block, const Weights& weights,      \
                      const PixelLikeness& by, PixelScratch& scratch, std::vector<float>& out);    \
    /* The mean colour of the pixels around (x, y) by their weights. */                            \
    void average_pixels(const SampleVectors& vectors, int x, int y, const PixelLikeness& by,       \
                        const float* weights, float* rgb, float* effective);                       \
    /* For each of some samples of pixel (x, y) that of their samples' colours, each also by the   \
     * likeness of its features: factors times differences, squared, are exponents. */             \
    void average_samples(                                                                          \
        const SampleVectors& vectors, const float* colors, std::span<const std::uint32_t> own,     \
        int x, int y, const PixelLikeness& by, const float* weights,                               \
        std::span<const float> factors, AroundScratch& scratch, float* rgb, float* effective);

namespace v2 {
WEFT_RPF_KERNELS
}
namespace v3 {
WEFT_RPF_KERNELS
}
namespace v4 {
WEFT_RPF_KERNELS
}
#undef WEFT_RPF_KERNELS

}  // namespace weft::rpf
