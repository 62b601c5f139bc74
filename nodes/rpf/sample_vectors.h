// The vectors that random parameter filtering compares: of each sample its position on the film,
// its random parameters, its scene features and its colour, side by side, so that a sample drawn
// from a neighbourhood is one place in memory. Source: Sen and Darabi 2012, Sec. 3 (the sample
// vector x = (p, r, f, c)).
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "filters/planes.h"
#include "runtime/large_array.h"
#include "samples/samples.h"

namespace weft {

// A component of the vectors: one number a sample.
struct VectorComponent {
    Role role = Role::none;  // position, random or feature
    int channel = 0;  // index among SampleVectors::channels: components of a channel are neighbours
};

// What a pixel's own samples say together, in planes: means of features and colours, the noise of
// these means, and how features change from pixel to pixel. By these two pixels can be alike
// although no two of their samples are.
struct PixelStatistics {
    static constexpr int most_reach =
        32;  // px, that planes may be read past the picture's left and right edges

    struct Group {
        size_t begin, end;     // components of a feature channel
        float deviation2 = 0;  // of its pixels' means over the picture
    };
    std::vector<Group> groups;
    size_t first = 0;  // the first feature component
    kernel::Planes planes;

    // Planes. Noise is the variance of a mean, of a feature summed over its components; slope a
    // feature's squared change to the next pixel, both axes together; samples how many a pixel has,
    // over the buffer's mean.
    int mean(size_t component) const { return int(component - first); }
    int color(size_t c) const { return int(features_ + c); }
    int color_noise(size_t c) const { return int(features_ + 3 + c); }
    int noise(size_t group) const { return int(features_ + 6 + group); }
    int slope(size_t group) const { return int(features_ + 6 + groups.size() + group); }
    int samples() const { return int(features_ + 6 + 2 * groups.size()); }
    void set_features(size_t components) { features_ = components; }

  private:
    size_t features_ = 0;
};

// Between which numbers each pixel's samples are, feature by feature, as codes of a byte that rise
// with the numbers: by these all of them are told at once to be near something, or not.
struct PixelBounds {
    // code(x) of a feature component: 1 to 254 as far as most numbers go, 0 and 255 past that.
    struct Scale {
        double low = 0, per_unit = 0;
        std::uint8_t code(double x) const {
            return std::uint8_t(std::clamp(1 + per_unit * (x - low), 0.0, 255.0));
        }
    };
    size_t first = 0;           // the first feature component
    std::vector<Scale> scales;  // of each from that on
    size_t pitch = 0;  // from component to component: the pixels, and some to read past the end
    // Of each component the pixels' codes; one without samples is between 255 and 0.
    LargeArray<std::uint8_t> low, high;

    bool empty() const { return low.empty(); }
    size_t bytes() const { return 2 * low.size(); }
};

struct SampleVectors {
    static constexpr size_t padding = 16;

    Samples samples;                    // what they were made of
    std::vector<std::string> channels;  // xy first, then random parameters, then features
    std::vector<VectorComponent> components;
    LargeArray<float> values;  // size x stride(), and some to read past the end
    std::vector<std::uint8_t>
        whole;  // of each sample: 0 where a number is not finite; empty: all are whole

    PixelStatistics pixels;
    PixelBounds bounds;  // empty where pixels have few samples, or some are not whole

    size_t size() const { return samples.size(); }
    // Floats from sample to sample: components, then red, green and blue.
    size_t stride() const { return components.size() + 3; }
    const float* of(size_t sample) const { return &values[sample * stride()]; }
    bool is_whole(size_t sample) const { return whole.empty() || whole[sample] != 0; }
    // Index of a channel's first component and one past its last.
    struct Range {
        size_t begin, end;
    };
    Range of_channel(size_t channel) const;
    size_t bytes() const {
        return values.size() * sizeof(float) + whole.size() +
               pixels.planes.values.size() * sizeof(float) + bounds.bytes() + samples.bytes();
    }
    void count(Items& items) const { items.add("samples", size()); }
};

WEFT_VALUE_TYPE(SampleVectors, "SampleVectors",
                "position, random parameters and features of each sample, side by side")

}  // namespace weft
