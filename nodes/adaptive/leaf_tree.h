// LeafTree: the boxes into which adaptive sampling cut the domain, and which samples lie in each.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/value.h"

namespace weft {

struct LeafTree {
    int width = 0, height = 0;      // px
    std::vector<std::string> axes;  // x and y first
    std::vector<float> extent;      // of each axis, px: x and y the picture's, others their scale
    std::vector<float> lo, hi;      // leaves x axes, px
    std::vector<std::uint32_t> first;    // leaves + 1: into `samples`
    std::vector<std::uint32_t> samples;  // leaf by leaf: indices into the buffer
    std::vector<float> mean;             // leaves x 3: radiance
    std::vector<float> error;            // of each leaf: volume times contrast

    size_t dimensions() const { return axes.size(); }
    size_t size() const { return error.size(); }
    double volume(size_t leaf) const {
        double v = 1;
        for (size_t d = 0; d < dimensions(); ++d)
            v *= double(hi[leaf * dimensions() + d]) - double(lo[leaf * dimensions() + d]);
        return v;
    }
    size_t bytes() const {
        return 4 *
               (lo.size() + hi.size() + first.size() + samples.size() + mean.size() + error.size());
    }
};

WEFT_VALUE_TYPE(LeafTree, "LeafTree", "boxes of an adaptively sampled domain")

}  // namespace weft
