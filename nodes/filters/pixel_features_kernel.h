// What a pixel's samples say of a channel: their mean and how far it can be trusted.
//   mean      sum w x / sum w over the pixel's samples, w their weights
//   variance  of that mean, not of the samples: sum w^2 (x - mean)^2 / ((sum w)^2 - sum w^2), which
//             for equal weights is the unbiased sample variance over the number of samples. It is
//             that of independent samples: stratified ones have less
// A pixel with a single sample has no deviation of its own: it is given that of the samples of its
// 3 x 3 pixels about their common mean. Where these are one sample too, nothing is known: 0.
// A sample whose values of a channel are not all finite, or whose weight is not a positive number,
// is left out of that channel; a pixel without samples gets 0 and 0. Where a channel may be
// infinite (depth of the background), a sample that is +inf is left out too, and a pixel of nothing
// else gets +inf.
// Sums run in double in the samples' order.
#pragma once
#include <span>

#include "samples/samples.h"

namespace weft::kernel {

struct PixelMoments {
    const Samples* samples;
    std::span<const float> values, weight;  // weight: empty where all are 1
    int components;
    bool may_be_infinite = false;
};

// What rows came to.
struct DroppedSamples {
    size_t count = 0;  // not finite
    size_t first = 0;  // the first of them, where there are any
};

// Rows [begin, end) of a channel into mean[(y width + x) stride + component], and variance likewise
// (null: not wanted). `used`, one a pixel, gets how many samples counted; null: not wanted.
// Cost: one pass over the samples, two where variance is wanted.
DroppedSamples moment_rows(const PixelMoments& in, int begin, int end, size_t stride, float* mean,
                           float* variance, float* used);

}  // namespace weft::kernel
