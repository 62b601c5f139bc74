#include "render/motion_keys.h"

#include <algorithm>
#include <cmath>

#include "render/keyed_motion.h"

namespace weft {
namespace {

// How far apart two places put the unit axes' ends, relative to `size`; and their origins.
float apart(const Affine& a, const Affine& b, float size, float way) {
    const float axes = std::max({length(a.x - b.x), length(a.y - b.y), length(a.z - b.z)});
    const float origins = length(a.origin - b.origin);
    return std::max(size > 0 ? axes / size : 0, way > 0 ? origins / way : 0);
}

}  // namespace

std::vector<Affine> fewest_keys(const std::vector<Affine>& samples) {
    constexpr float near_enough = 1.0f / 500;
    const Affine& first = samples.front();
    const float size = std::max({length(first.x), length(first.y), length(first.z)});
    float way = 0, turn = 0;
    for (const Affine& s : samples) {
        way = std::max(way, length(s.origin - first.origin));
        turn = std::max(turn, apart(s, first, size, 0));
    }
    if (samples.size() < 2 || (turn < 1e-6f && way <= 1e-7f * (length(first.origin) + size)))
        return {first};
    const bool sound = std::all_of(samples.begin(), samples.end(), is_invertible);
    const size_t steps = samples.size() - 1;
    for (size_t stride = steps; stride > 1 && sound; stride /= 2) {
        std::vector<Affine> keys;
        for (size_t i = 0; i <= steps; i += stride) keys.push_back(samples[i]);
        const render::KeyedMotion between(keys);
        float worst = 0;
        for (size_t i = 0; i <= steps; ++i)
            worst =
                std::max(worst, apart(between.at(float(i) / float(steps)), samples[i], size, way));
        if (worst < near_enough) return keys;
    }
    return samples;
}

}  // namespace weft
