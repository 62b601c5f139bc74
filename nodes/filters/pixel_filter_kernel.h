// Samples to pixels: each output channel is the mean of the samples about the pixel's centre,
// weighted by a pixel filter at their true positions (and by their own `weight`, where there is
// one).
//   samples   any spp, constant or not, up to a pixel outside their own pixel
//   channels  what to filter; a sample whose values of a channel are not all finite, or whose
//   weight
//             is not a positive number, is left out of that channel
//   a pixel   no sample with a weight, or weights that cancel (negative lobes): fallback, see below
// Sums run in double over source pixels in row order and samples in their order, so bits do not
// depend on bands or threads.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "filters/pixel_filters.h"
#include "samples/samples.h"

namespace weft::kernel {

struct FilterInput {
    const Samples* samples;
    std::span<const float> xy, weight;  // weight: empty where all are 1
    struct Source {
        std::span<const float> values;
        int components;
    };
    std::vector<Source> channels;
    int slack = 0;  // whole pixels that samples lie outside their own, at most

    int components() const;  // of all channels
};
// `slack` is looked for (0 to 2); channels in order.
FilterInput filter_input(const Samples& samples, const std::vector<const Channel*>& channels);

// Rows [begin, end) of the picture, out[(y - begin) * width + x][components]. Returns how many
// pixels of them have a channel that no sample reached. Such a channel gets +inf where samples
// reached that are all +inf there (depth of the background), else 0. Cost: 2 (2 r + 1) filter
// values and (2 r + 1)^2 multiply-adds a sample and channel, r the reach in pixels.
size_t filter_rows(const FilterInput& in, const PixelFilter& filter, int begin, int end,
                   float* out);

// The same for one pixel, written down as defined: what filter_rows() is held to.
bool filter_pixel(const FilterInput& in, const PixelFilter& filter, int x, int y, float* out);

// The sample nearest to the centre of each pixel, of all that lie in reach (own pixel and
// neighbours).
size_t nearest_rows(const FilterInput& in, int begin, int end, float* out);

}  // namespace weft::kernel
