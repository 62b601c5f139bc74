// A step between two values without corners: 0 up to `low`, 1 from `high` on, 3 t^2 - 2 t^3 between.
#pragma once
#include <algorithm>

namespace weft {

inline float smooth_step(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

}  // namespace weft
