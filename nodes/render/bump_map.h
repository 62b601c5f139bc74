// A bump map as the normal map that it makes (tangent space, x right and y up the picture, stored
// as 0.5 + 0.5 n).
//   heights   grey: the mean of its channels, `scale` texels from black to white; differences of
//             the two neighbours of a texel, the picture repeated (Blinn 1978, Sec. 3, for a
//             surface on which texels are square). So a bump is as steep as it is drawn, whatever
//             the surface's size
//   normals   many files name a normal map as their bump map; one is taken as it is
#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "samples/vec3.h"

namespace weft {

// Whether nine tenths of the pixels are unit normals that look out of the picture. Greys are not.
//   rgb   N x 3 in [0, 1]
inline bool holds_normals(std::span<const float> rgb) {
    size_t normals = 0;
    for (size_t i = 0; i + 2 < rgb.size(); i += 3) {
        const auto [low, high] = std::minmax({rgb[i], rgb[i + 1], rgb[i + 2]});
        const Vec3 n{2 * rgb[i] - 1, 2 * rgb[i + 1] - 1, 2 * rgb[i + 2] - 1};
        normals += high - low > 0.1f && n.z > 0 && std::fabs(length(n) - 1) < 0.15f;
    }
    return 10 * normals >= 9 * (rgb.size() / 3);
}

// In place.
//   rgb   width x height x 3, top row first
inline void bumps_to_normals(std::span<float> rgb, int width, int height, float scale) {
    if (holds_normals(rgb)) return;
    std::vector<float> heights(rgb.size() / 3);
    for (size_t i = 0; i < heights.size(); ++i)
        heights[i] = (rgb[3 * i] + rgb[3 * i + 1] + rgb[3 * i + 2]) / 3;
    const auto at = [&](int x, int y) {
        return heights[size_t((y + height) % height) * size_t(width) + size_t((x + width) % width)];
    };
    float* out = rgb.data();
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x, out += 3) {
            const float right = 0.5f * scale * (at(x + 1, y) - at(x - 1, y));
            const float up = 0.5f * scale * (at(x, y - 1) - at(x, y + 1));
            const Vec3 n = unit(Vec3{-right, -up, 1});
            out[0] = 0.5f + 0.5f * n.x, out[1] = 0.5f + 0.5f * n.y, out[2] = 0.5f + 0.5f * n.z;
        }
}

}  // namespace weft
