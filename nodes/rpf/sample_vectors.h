// The vectors that random parameter filtering compares: of each sample its position on the film,
// its random parameters, its scene features and its colour, side by side, so that a sample drawn
// from a neighbourhood is one place in memory. Source: Sen and Darabi 2012, Sec. 3 (the sample
// vector x = (p, r, f, c)).
#pragma once
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

struct SampleVectors {
    static constexpr size_t padding = 16;

    Samples samples;                    // what they were made of
    std::vector<std::string> channels;  // xy first, then random parameters, then features
    std::vector<VectorComponent> components;
    LargeArray<float> values;  // size x stride(), and some to read past the end
    std::vector<std::uint8_t>
        whole;  // of each sample: 0 where a number is not finite; empty: all are whole

    PixelStatistics pixels;

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
               pixels.planes.values.size() * sizeof(float) + samples.bytes();
    }
    void count(Items& items) const { items.add("samples", size()); }
};

WEFT_VALUE_TYPE(SampleVectors, "SampleVectors",
                "position, random parameters and features of each sample, side by side")

}  // namespace weft
