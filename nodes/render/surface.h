// Where on a surface a ray hit, at that time and at any other: the same point of the mesh (or
// light), carried by vertex and instance motion just as Embree interpolates them.
#pragma once
#include "render/ray_scene.h"

namespace weft::render {

// Texture coordinates at a point, and how the surface runs along them.
struct UvFrame {
    Vec2 uv;                // 0 where the mesh has none
    Vec3 along_u, along_v;  // dposition/du, dposition/dv; 0: none
};

struct SurfacePoint {
    Vec3 position;
    Vec3 geometric;   // unit; of a light: towards where it shines
    Vec3 shading;     // unit, interpolated; on the side of `geometric` as the mesh has it
    UvFrame texture;  // by the mesh's first set of texture coordinates
    float error = 0;  // about how far off `position` may be from rounding, world units
};

// `u`, `v`, `primitive` as Rays has them.
SurfacePoint surface_at(const Object& object, std::uint32_t primitive, float u, float v,
                        float time);
// The same point's texture coordinates by a set of the mesh's (Mesh::uv_set).
UvFrame uv_frame_at(const Object& object, std::uint32_t primitive, float u, float v, float time,
                    int set);
Vec3 position_at(const Object& object, std::uint32_t primitive, float u, float v, float time);

// A ray's start, moved off the surface to the side it leaves on.
inline Vec3 offset_origin(Vec3 position, Vec3 geometric, float error, Vec3 direction) {
    return position + geometric * (dot(geometric, direction) >= 0 ? error : -error);
}

}  // namespace weft::render
