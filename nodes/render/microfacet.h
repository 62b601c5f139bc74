// The GGX microfacet distribution (Trowbridge and Reitz 1975; Walter et al. 2007) with Smith's
// height-correlated masking-shadowing (Heitz 2014) and sampling of visible normals (Heitz 2018).
// Isotropic; alpha > 0; z is the macroscopic normal.
#pragma once
#include <algorithm>

#include "render/bsdf_sample.h"

namespace weft::render {

struct Ggx {
    float alpha;

    // Density of microfacet normals, per projected area.
    float distribution(Vec3 m) const {
        const float a2 = alpha * alpha, c2 = m.z * m.z;
        // 1 - c2 as x^2 + y^2: no loss of digits about the pole, where sharp lobes live.
        const float d = (m.x * m.x + m.y * m.y) + a2 * c2;
        return m.z > 0 ? a2 / (pi * d * d) : 0;
    }
    float lambda(Vec3 v) const {
        const float c2 = v.z * v.z;
        if (c2 <= 0) return 1e18f;
        const float tan2 = (v.x * v.x + v.y * v.y) / c2;
        return 0.5f * (std::sqrt(1 + alpha * alpha * tan2) - 1);
    }
    float masking(Vec3 v) const { return 1 / (1 + lambda(v)); }
    float masking_shadowing(Vec3 out, Vec3 in) const { return 1 / (1 + lambda(out) + lambda(in)); }
    // Both on opposite sides: uncorrelated heights.
    float masking_through(Vec3 out, Vec3 in) const { return masking(out) * masking(in); }

    // Density of the normals that `out` (z > 0) sees.
    float visible(Vec3 out, Vec3 m) const {
        return masking(out) * std::max(dot(out, m), 0.0f) * distribution(m) / out.z;
    }
    Vec3 sample_visible(Vec3 out, float a, float b) const {
        const Vec3 v = unit(Vec3{alpha * out.x, alpha * out.y, out.z});
        const float l2 = v.x * v.x + v.y * v.y;
        const Vec3 t1 = l2 > 0 ? Vec3{-v.y, v.x, 0} * (1 / std::sqrt(l2)) : Vec3{1, 0, 0};
        const Vec3 t2 = cross(v, t1);
        const float r = std::sqrt(a), phi = 2 * pi * b, p1 = r * std::cos(phi);
        const float s = 0.5f * (1 + v.z);
        const float p2 = (1 - s) * std::sqrt(std::max(0.0f, 1 - p1 * p1)) + s * r * std::sin(phi);
        const Vec3 n = t1 * p1 + t2 * p2 + v * std::sqrt(std::max(0.0f, 1 - p1 * p1 - p2 * p2));
        return unit(Vec3{alpha * n.x, alpha * n.y, std::max(n.z, 1e-7f)});
    }
};

// Below this alpha a surface is taken for a mirror: its lobe is narrower than floats tell apart.
inline constexpr float smallest_alpha = 1e-3f;
inline float alpha_of(float roughness) {
    return roughness * roughness;
}

}  // namespace weft::render
