// Sample buffers for tests: samples placed in pixels, to be given channels by whoever wants them.
#pragma once
#include <array>

#include "samples/random.h"
#include "samples/samples.h"

namespace weft {

// count_of(pixel) samples a pixel, sample i at place(i) of its pixel, in [0, 1)^2. Where all pixels
// have as many, the buffer says so by spp, else by offsets.
template <class Count, class Place>
Samples placed_samples(int width, int height, Count&& count_of, Place&& place) {
    Samples s;
    s.width = width;
    s.height = height;
    std::vector<std::uint64_t> first{0};
    std::vector<float> xy;
    bool even = true;
    for (size_t p = 0; p < s.pixels(); ++p) {
        const size_t count = count_of(p);
        even = even && count == count_of(size_t(0));
        for (size_t k = 0; k < count; ++k) {
            const std::array<float, 2> at = place(xy.size() / 2);
            xy.push_back(float(p % size_t(width)) + at[0]);
            xy.push_back(float(p / size_t(width)) + at[1]);
        }
        first.push_back(xy.size() / 2);
    }
    s.set_size(xy.size() / 2);
    if (even && s.pixels() > 0 && first[1] > 0)
        s.spp = int(first[1]);
    else
        s.first = Array<std::uint64_t>(std::move(first));
    s.add("xy", 2, std::move(xy));
    return s;
}

inline std::array<float, 2> middle(size_t) {
    return {0.5f, 0.5f};
}

}  // namespace weft
