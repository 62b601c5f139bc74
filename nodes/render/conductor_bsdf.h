// GGX reflection off a metal, Fresnel by Schlick from its colour at normal incidence.
// Source: Walter et al. 2007; sampling of visible normals: Heitz 2018.
#pragma once
#include "render/microfacet.h"

namespace weft::render {

struct ConductorBsdf {
    Vec3 normal_incidence;
    float alpha;

    BsdfValue eval(Vec3 out, Vec3 in) const {
        if (out.z <= 0 || in.z <= 0) return {};
        const Ggx ggx{alpha};
        const Vec3 m = unit(out + in);
        const float d = ggx.distribution(m);
        const float f = d * ggx.masking_shadowing(out, in) / (4 * out.z);
        return {{}, schlick(normal_incidence, dot(out, m)) * f, d * ggx.masking(out) / (4 * out.z)};
    }
    BsdfSample sample(Vec3 out, float, float a, float b) const {
        if (out.z <= 0) return {};
        const Vec3 in = reflected(out, Ggx{alpha}.sample_visible(out, a, b));
        return {in, eval(out, in)};
    }
};

}  // namespace weft::render
