// Pictures as the measures see them: R G B of every pixel, three floats each, row by row.
#pragma once
#include <vector>

#include "image/image.h"
#include "runtime/context.h"

namespace weft {

struct RgbPixels {
    int width = 0, height = 0;
    std::vector<float> values;  // width x height x 3
    size_t not_finite = 0;      // values that were NaN or infinite, taken as 0
    const float* at(int x, int y) const {
        return values.data() + (size_t(y) * size_t(width) + size_t(x)) * 3;
    }
};

// The values as they are; a picture of one channel (or Y) is grey.
RgbPixels rgb_values(const Image& image);

// Un-tone-mapped sRGB in [0, 1]: scene-linear spaces go through linear Rec.709 (Bradford
// adaptation), are clamped and get the curve of IEC 61966-2-1; display pictures are clamped only.
RgbPixels display_values(const Image& image, Context& ctx);

// sRGB's curve and back, for [0, 1].
float srgb_from_linear(float value);
float linear_from_srgb(float value);

}  // namespace weft
