// Lambert's reflection: f = albedo / pi, on the side of the normal.
#pragma once
#include <algorithm>

#include "render/bsdf_sample.h"
#include "samples/samplers.h"

namespace weft::render {

// The unit square to directions about z, density cos / pi (Malley's method).
inline Vec3 cosine_direction(float a, float b) {
    const Disk d = concentric_disk(a, b);
    return {d.u, d.v, std::sqrt(std::max(1 - d.u * d.u - d.v * d.v, 1e-12f))};
}

struct DiffuseBsdf {
    Vec3 albedo;

    BsdfValue eval(Vec3 out, Vec3 in) const {
        if (out.z <= 0 || in.z <= 0) return {};
        return {albedo * (in.z / pi), {}, in.z / pi};
    }
    BsdfSample sample(Vec3 out, float, float a, float b) const {
        const Vec3 in = cosine_direction(a, b);
        return {in, eval(out, in)};
    }
};

}  // namespace weft::render
