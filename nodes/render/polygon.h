// Triangles of a polygon in space, by cutting off ears: right for concave ones too.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "samples/vec3.h"

namespace weft {

// Corners as indices into `points`, as they turn. n - 2 triangles; a damaged polygon gives a fan.
std::vector<std::array<int, 3>> triangulated(std::span<const Vec3> points);

}  // namespace weft
