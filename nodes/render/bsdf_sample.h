// What every BSDF answers with. Directions are unit, in the shading frame (normal along z), and
// point away from the surface: `out` towards the viewer, `in` towards the light.
//   eval(out, in)            f times |cos in|, split by lobe, and the density with which sample()
//                            gives `in`, a solid angle's; zero where a lobe is a delta
//   sample(out, lobe, a, b)  a direction from numbers in [0, 1); density 0: none
#pragma once
#include "render/affine.h"

namespace weft::render {

inline constexpr Vec3 white{1, 1, 1};

struct BsdfValue {
    Vec3 diffuse{}, specular{};  // f |cos|
    float density = 0;
    Vec3 sum() const { return diffuse + specular; }
};

struct BsdfSample {
    Vec3 in{};
    BsdfValue value;     // a delta: weight of the lobe times `density`
    bool delta = false;  // `density` is then a probability
    bool through = false;
    bool unbent = false;  // a delta that goes straight on: `in` is -out
};

inline Vec3 reflected(Vec3 out, Vec3 about) {
    return about * (2 * dot(out, about)) - out;
}
inline float luminance(Vec3 c) {
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}
inline float largest(Vec3 c) {
    return std::max(c.x, std::max(c.y, c.z));
}

// Schlick's approximation (1994).
inline float schlick_weight(float cosine) {
    const float m = 1 - std::min(std::max(cosine, 0.0f), 1.0f), m2 = m * m;
    return m2 * m2 * m;
}
inline Vec3 schlick(Vec3 normal_incidence, float cosine) {
    const float w = schlick_weight(cosine);
    return normal_incidence * (1 - w) + white * w;
}

// Unpolarised Fresnel reflectance of a dielectric; eta: index behind the surface over that before
// it, on the side of the positive `cosine`.
inline float dielectric_fresnel(float cosine, float eta) {
    const float sine2 = (1 - cosine * cosine) / (eta * eta);
    if (sine2 >= 1) return 1;
    const float behind = std::sqrt(1 - sine2);
    const float s = (cosine - eta * behind) / (cosine + eta * behind),
                p = (eta * cosine - behind) / (eta * cosine + behind);
    return 0.5f * (s * s + p * p);
}

}  // namespace weft::render
