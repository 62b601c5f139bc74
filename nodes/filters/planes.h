// Planes: the channels of a picture apart, with a margin of zeros left and right, so that kernels
// may read past these edges.
#pragma once
#include <cstddef>

#include "runtime/large_array.h"

namespace weft::kernel {

struct Planes {
    int width = 0, height = 0, margin = 0, count = 0;
    size_t pitch = 0, size = 0;  // floats from row to row, from plane to plane
    LargeArray<float> values;

    Planes() = default;
    Planes(int picture_width, int picture_height, int planes, int margin_px)
        : width(picture_width), height(picture_height), margin(margin_px), count(planes) {
        // Rows start 16 floats after one another's ends; never at a distance of 4 KiB, which would
        // put them all into the same lines of the nearest cache.
        pitch = (size_t(width) + 2 * size_t(margin) + 31) / 16 * 16;
        if (pitch % 256 == 0) pitch += 16;
        size = pitch * size_t(height);
        values.resize(size * size_t(count) + pitch + 64, 0.0f);
    }
    // Pixel 0 of row y of the picture; x may be `margin` and a vector outside.
    float* row(int plane, int y) { return values.data() + offset(plane, y); }
    const float* row(int plane, int y) const { return values.data() + offset(plane, y); }

  private:
    size_t offset(int plane, int y) const {
        return size_t(plane) * size + size_t(y) * pitch + size_t(margin) + 32;
    }
};

}  // namespace weft::kernel
