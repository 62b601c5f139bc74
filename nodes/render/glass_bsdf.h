// Clear glass: reflected or refracted, by Fresnel's law; `tint` colours what goes through. The
// normal points out of the glass; `out` may lie on either side.
// Radiance is scaled by eta^2 where it enters another medium (Veach 1997, Sec. 5.2).
#pragma once
#include "render/bsdf_sample.h"

namespace weft::render {

struct GlassBsdf {
    Vec3 tint;
    float ior;

    BsdfValue eval(Vec3, Vec3) const { return {}; }
    BsdfSample sample(Vec3 out, float lobe, float, float) const {
        const float side = out.z >= 0 ? 1.0f : -1.0f, cosine = std::fabs(out.z);
        const float eta = side > 0 ? ior : 1 / ior;
        const float reflect = dielectric_fresnel(cosine, eta);
        if (lobe < reflect) return {{-out.x, -out.y, out.z}, {{}, white * reflect, reflect}, true};
        const float behind = std::sqrt(std::max(0.0f, 1 - (1 - cosine * cosine) / (eta * eta)));
        const Vec3 in = unit(Vec3{-out.x / eta, -out.y / eta, -side * behind});
        const float pass = 1 - reflect;
        return {in, {{}, tint * (pass / (eta * eta)), pass}, true, true};
    }
};

}  // namespace weft::render
