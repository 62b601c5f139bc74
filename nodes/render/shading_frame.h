// ShadingFrame: an orthonormal frame about a unit normal, z along it.
// Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
#pragma once
#include "samples/vec3.h"

namespace weft::render {

struct ShadingFrame {
    Vec3 x, y, z;

    ShadingFrame() = default;
    explicit ShadingFrame(Vec3 normal) : z(normal) {
        const float sign = std::copysign(1.0f, z.z);
        const float a = -1 / (sign + z.z), b = z.x * z.y * a;
        x = {1 + sign * z.x * z.x * a, sign * b, -sign * z.x};
        y = {b, sign + z.y * z.y * a, -z.y};
    }
    Vec3 to_local(Vec3 v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
    Vec3 to_world(Vec3 v) const { return x * v.x + y * v.y + z * v.z; }
};

}  // namespace weft::render
