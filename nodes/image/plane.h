// Plane: one float a pixel, and separable filters over it. Beyond the edge the edge's pixel
// repeats.
#pragma once
#include <cmath>
#include <vector>

#include "runtime/context.h"

namespace weft {

struct Plane {
    int width = 0, height = 0;
    std::vector<float> values;
    Plane() = default;
    Plane(int w, int h) : width(w), height(h), values(size_t(w) * size_t(h)) {}
    float* row(int y) { return values.data() + size_t(y) * size_t(width); }
    const float* row(int y) const { return values.data() + size_t(y) * size_t(width); }
};

// Weights of -radius ... radius.
using Taps = std::vector<float>;

// sum of along_x[i] along_y[j] in(x + i, y + j)
Plane filtered(const Plane& in, const Taps& along_x, const Taps& along_y, Context& ctx);

}  // namespace weft
