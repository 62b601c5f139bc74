// The sheared filter of pictures: a pixel's value is the mean of all samples that its mean velocity
// and its mean circle of confusion carry into it, each weighted by how much of shutter and lens it
// stands for there.
//   across  the pixel's box, wider by a Gaussian of deviation `across` sqrt(1/W^2 - 1/W_p^2) px in
//           that what is left is a box of the same variance: so W = W_p is the plain pixel
//   along   a Gaussian of deviation `along` / B of shutter or lens; B = 0: any sample of the path
//           stands for all of it
//   middle  samples that happen to lie to one side of the filter's middle are carried there by the
//           slope of their own values (a regression): a ramp is exact, however few they are
// Source: Egan et al. 2009, Sec. 4 and 5.  Departures: boxes and exact intervals of time instead of
// Gaussians, so that the static limit is the box filter; where slopes spread across the way of
// motion, sliding is cut shorter instead of the pixel made wider; a pixel whose filter has less
// than twice the samples, by their weights, that it has itself keeps its own mean, whose samples
// are better spread over it than those from elsewhere. Cost: one weight for each sample in the
// swept footprint of a pixel.
#pragma once
#include <vector>

#include "adaptive/sample_paths.h"
#include "adaptive/slopes.h"
#include "samples/lens_shape.h"

namespace weft::adaptive {

struct ShearedSettings {
    float across = 0.08f, along = 0.2f, cap = 2.5f;
    float wide = 4;        // px: wider ranges about 0 are not filtered
    float gain = 2;        // times a pixel's own samples that are worth taking others for
    bool fallback = true;  // the pixel's own mean there, and where few samples would have a say
};

class ShearedFilter {
  public:
    // Keeps references.
    ShearedFilter(const Samples& samples, const Image& slopes, const ShearedSettings& settings);

    struct Pixel {
        double rgb[3] = {0, 0, 0};
        float effective = 0;    // samples, by their weights: (sum w)^2 / sum w^2
        bool own_mean = false;  // the pixel's own samples alone
    };
    const SlopeReader& slopes() const { return slopes_; }
    // `own_mean` and effective 0: there are no samples near.
    Pixel filtered(int x, int y) const;

  private:
    struct Filter;
    struct Sums;
    static constexpr float least_to_fit = 6;  // effective samples

    Filter filter_of(const PixelSlopes& slopes, int x, int y) const;
    void gather(const Filter& filter, Sums& sums) const;
    float weight(const Filter& filter, size_t sample, std::uint32_t pixel) const;
    float lens_weight(const Filter& filter, float dx, float dy, float u, float v) const;
    float time_weight(const Filter& filter, float dx, float dy, float t) const;
    Pixel own_mean(int x, int y) const;

    const Samples& samples_;
    SamplePaths paths_;
    SlopeReader slopes_;
    ShearedSettings settings_;
    ShutterCurve shutter_;
    std::span<const float> rgb_, weight_;
    double mean_time_ = 0.5;
    float overhang_ = 0;  // px: how far any sample lies outside its pixel
};

}  // namespace weft::adaptive
