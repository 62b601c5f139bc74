// Affine maps: how to make them and combine them. Angles in radians, counter-clockwise seen from
// the axis's tip; everything right-handed.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "render/scene.h"

namespace weft {

inline constexpr float pi = std::numbers::pi_v<float>;
constexpr float radians(float degrees) {
    return degrees * (pi / 180);
}
inline Affine translate(Vec3 by) {
    return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, by};
}
inline Affine scale(Vec3 by) {
    return {{by.x, 0, 0}, {0, by.y, 0}, {0, 0, by.z}, {}};
}
inline Affine scale(float by) {
    return scale(Vec3{by, by, by});
}
// `axis` need not be unit; zero: no rotation.
inline Affine rotate(Vec3 axis, float angle) {
    const float size = length(axis);
    if (!(size > 0)) return {};
    const Vec3 a = axis * (1 / size);
    const float c = std::cos(angle), s = std::sin(angle);
    const auto turned = [&](Vec3 v) { return v * c + cross(a, v) * s + a * (dot(a, v) * (1 - c)); };
    return {turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1}), {}};
}
// A camera's or light's place: at `eye`, its -z towards `target`. `up` parallel to the view:
// another is taken.
inline Affine look_at(Vec3 eye, Vec3 target, Vec3 up = {0, 1, 0}) {
    Vec3 back = eye - target;
    back = dot(back, back) > 0 ? unit(back) : Vec3{0, 0, 1};
    Vec3 right = cross(up, back);
    if (dot(right, right) < 1e-12f * dot(up, up) || !(dot(up, up) > 0))
        right = cross(std::fabs(back.z) < 0.9f ? Vec3{0, 0, 1} : Vec3{1, 0, 0}, back);
    right = unit(right);
    return {right, cross(back, right), back, eye};
}
inline float determinant(const Affine& m) {
    return dot(m.x, cross(m.y, m.z));
}
inline bool finite(Vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool finite(const Affine& m) {
    return finite(m.x) && finite(m.y) && finite(m.z) && finite(m.origin);
}
inline bool is_invertible(const Affine& m) {
    const float size = length(m.x) * length(m.y) * length(m.z);
    return std::isfinite(size) && size > 1e-30f && std::fabs(determinant(m)) > 1e-6f * size;
}
// Of an invertible one.
inline Affine inverse(const Affine& m) {
    const float scale = 1 / determinant(m);
    const Vec3 a = cross(m.y, m.z) * scale, b = cross(m.z, m.x) * scale,
               c = cross(m.x, m.y) * scale;
    Affine out{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}, {}};
    out.origin = -out.vector(m.origin);
    return out;
}
// Normals go by the transposed inverse; not unit.
inline Vec3 transformed_normal(const Affine& m, Vec3 n) {
    const Vec3 out = cross(m.y, m.z) * n.x + cross(m.z, m.x) * n.y + cross(m.x, m.y) * n.z;
    return determinant(m) < 0 ? -out : out;
}
// Entry by entry: a straight way for every point.
inline Affine lerp(const Affine& a, const Affine& b, float s) {
    return {lerp(a.x, b.x, s), lerp(a.y, b.y, s), lerp(a.z, b.z, s), lerp(a.origin, b.origin, s)};
}
// The place without its scale and skew: what is left is a rotation and a translation.
inline Affine rigid(const Affine& m) {
    return look_at(m.origin, m.origin - m.z, m.y);
}

// `keys` places at equal steps of the shutter: `start` moved by `velocity` (a shutter) and turned
// by `angle` about `axis` through its own origin. An angle needs a key every 120 degrees or less.
inline std::vector<Affine> moving(const Affine& start, Vec3 velocity, Vec3 axis = {0, 1, 0},
                                  float angle = 0) {
    const int steps = std::max(1, int(std::ceil(std::fabs(angle) / radians(60) - 1e-3f)));
    std::vector<Affine> keys;
    for (int i = 0; i <= steps; ++i) {
        const float t = float(i) / float(steps);
        Affine key = rotate(axis, angle * t) * Affine{start.x, start.y, start.z, {}};
        key.origin = start.origin + velocity * t;
        keys.push_back(key);
    }
    return keys;
}

}  // namespace weft
