// What lies behind everything in the garden: the ground with its tiled path, and the sky.
#pragma once
#include "samples/analytic_geometry.h"

namespace weft::analytic {

inline constexpr float ground = 1.1f;                    // y of the ground: the camera's height
inline constexpr float field_extent = 40, field_z = 41;  // the ground is x, z - field_z in +-extent
inline constexpr float path_half = 1.15f;
float path_middle(float z);  // x of the path

Surface ground_texture(const Paint& paint, float a, float b, Vec3 n);
Vec3 dusk_sky(float x, float y);

}  // namespace weft::analytic
