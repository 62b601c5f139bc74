// How far lens and shutter spread what is seen in some pixels, as a rule.
#pragma once
#include <cstdint>
#include <vector>

#include "light-field/hierarchy.h"

namespace weft::light_field {

struct MeanBlur {
    float lens = 0;  // px: diameter of the circle of confusion
    float path = 0;  // px: length of the path over the shutter
};

// Root mean squares over the groups of samples that may be seen in pixels [x0, x1) x [y0, y1) at any
// (u, v, t); groups without bounds are left out. `groups` is scratch.
MeanBlur mean_blur(const Hierarchy& h, int x0, int y0, int x1, int y1,
                   std::vector<std::uint32_t>& groups);

}  // namespace weft::light_field
