// How far lens and shutter may spread a sample that is seen in some pixels.
#pragma once
#include <cstdint>
#include <vector>

#include "light-field/hierarchy.h"

namespace weft::light_field {

struct BlurBounds {
    float lens = 0;  // px: diameter of the largest circle of confusion
    float path = 0;  // px: length of the longest path over the shutter
};

// Of the samples that may be seen in pixels [x0, x1) x [y0, y1) at any (u, v, t); infinite where no
// bound is known. `groups` is scratch.
BlurBounds blur_bounds(const Hierarchy& h, int x0, int y0, int x1, int y1,
                       std::vector<std::uint32_t>& groups);

}  // namespace weft::light_field
