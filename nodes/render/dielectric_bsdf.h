// Rough glass: GGX reflection and refraction. The normal points out of the glass; `out` may lie on
// either side. Source: Walter et al. 2007, with visible normals sampled (Heitz 2018).
#pragma once
#include "render/microfacet.h"

namespace weft::render {

struct DielectricBsdf {
    Vec3 tint;
    float ior, alpha;

    BsdfValue eval(Vec3 out, Vec3 in) const {
        // Seen from the other side everything is mirrored, and so is the index.
        const float side = out.z >= 0 ? 1.0f : -1.0f, eta = side > 0 ? ior : 1 / ior;
        out = out * side, in = in * side;
        if (out.z == 0 || in.z == 0) return {};
        const Ggx ggx{alpha};
        if (in.z > 0) {
            const Vec3 m = unit(out + in);
            const float reflect = dielectric_fresnel(dot(out, m), eta), d = ggx.distribution(m);
            return {{},
                    white * (reflect * d * ggx.masking_shadowing(out, in) / (4 * out.z)),
                    reflect * d * ggx.masking(out) / (4 * out.z)};
        }
        Vec3 m = out + in * eta;
        if (dot(m, m) < 1e-12f) return {};
        m = unit(m);
        if (m.z < 0) m = -m;
        const float om = dot(out, m), im = dot(in, m);
        if (om <= 0 || im >= 0) return {};
        const float pass = 1 - dielectric_fresnel(om, eta), d = ggx.distribution(m);
        const float stretch = om + eta * im;
        // dm/din = eta^2 |im| / stretch^2; of radiance, the eta^2 is not there.
        const float common = d * std::fabs(im) / (stretch * stretch);
        return {{},
                tint * (pass * common * om * ggx.masking_through(out, in) / out.z),
                pass * common * eta * eta * om * ggx.masking(out) / out.z};
    }
    BsdfSample sample(Vec3 out, float lobe, float a, float b) const {
        const float side = out.z >= 0 ? 1.0f : -1.0f, eta = side > 0 ? ior : 1 / ior;
        const Vec3 up = out * side;
        if (up.z < 1e-6f) return {};
        const Vec3 m = Ggx{alpha}.sample_visible(up, a, b);
        const float om = dot(up, m);
        if (om <= 0) return {};
        Vec3 in;
        const bool reflects = lobe < dielectric_fresnel(om, eta);
        if (reflects) {
            in = reflected(up, m);
        } else {
            const float sine2 = (1 - om * om) / (eta * eta);
            if (sine2 >= 1) return {};
            in = m * (om / eta - std::sqrt(1 - sine2)) - up * (1 / eta);
        }
        if ((in.z > 0) != reflects) return {};
        in = unit(in) * side;
        return {in, eval(out, in), false, !reflects};
    }
};

}  // namespace weft::render
