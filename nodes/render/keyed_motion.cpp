#include "render/keyed_motion.h"

#include <algorithm>

namespace weft::render {
namespace {

Quaternion quaternion_of(Vec3 x, Vec3 y, Vec3 z) {
    // The largest of the four is found first, so that no division is by a small number.
    const float trace = x.x + y.y + z.z;
    Quaternion q;
    if (trace > 0) {
        const float s = 2 * std::sqrt(trace + 1);
        q = {s / 4, (y.z - z.y) / s, (z.x - x.z) / s, (x.y - y.x) / s};
    } else if (x.x >= y.y && x.x >= z.z) {
        const float s = 2 * std::sqrt(1 + x.x - y.y - z.z);
        q = {(y.z - z.y) / s, s / 4, (y.x + x.y) / s, (z.x + x.z) / s};
    } else if (y.y >= z.z) {
        const float s = 2 * std::sqrt(1 + y.y - x.x - z.z);
        q = {(z.x - x.z) / s, (y.x + x.y) / s, s / 4, (z.y + y.z) / s};
    } else {
        const float s = 2 * std::sqrt(1 + z.z - x.x - y.y);
        q = {(x.y - y.x) / s, (z.x + x.z) / s, (z.y + y.z) / s, s / 4};
    }
    const float n = 1 / std::sqrt(q.r * q.r + q.i * q.i + q.j * q.j + q.k * q.k);
    return {q.r * n, q.i * n, q.j * n, q.k * n};
}

float cosine(const Quaternion& a, const Quaternion& b) {
    return a.r * b.r + a.i * b.i + a.j * b.j + a.k * b.k;
}

Quaternion slerp(const Quaternion& a, Quaternion b, float s) {
    float c = cosine(a, b);
    if (c < 0) b = {-b.r, -b.i, -b.j, -b.k}, c = -c;
    float wa = 1 - s, wb = s;
    if (c < 0.9995f) {
        const float angle = std::acos(c), scale = 1 / std::sin(angle);
        wa = std::sin((1 - s) * angle) * scale;
        wb = std::sin(s * angle) * scale;
    }
    const Quaternion q{wa * a.r + wb * b.r, wa * a.i + wb * b.i, wa * a.j + wb * b.j,
                       wa * a.k + wb * b.k};
    const float n = 1 / std::sqrt(cosine(q, q));
    return {q.r * n, q.i * n, q.j * n, q.k * n};
}

bool same_rotation(const Quaternion& a, const Quaternion& b) {
    // Half an angle of 8e-4: between such keys a straight line is off by less than 1e-6.
    return std::fabs(cosine(a, b)) > 1 - 3e-7f;
}

}  // namespace

Decomposed decompose(const Affine& m) {
    Decomposed out;
    const Vec3 x = unit(m.x);
    out.scale.x = length(m.x);
    out.skew_xy = dot(x, m.y);
    const Vec3 across = m.y - x * out.skew_xy, y = unit(across);
    out.scale.y = dot(y, m.y);
    const Vec3 z = cross(x, y);  // a mirrored transform has a negative scale along z
    out.skew_xz = dot(x, m.z);
    out.skew_yz = dot(y, m.z);
    out.scale.z = dot(z, m.z);
    out.rotation = quaternion_of(x, y, z);
    out.translation = m.origin;
    return out;
}

Affine compose(const Decomposed& d) {
    const auto [r, i, j, k] = d.rotation;
    const Vec3 x{1 - 2 * (j * j + k * k), 2 * (i * j + r * k), 2 * (i * k - r * j)};
    const Vec3 y{2 * (i * j - r * k), 1 - 2 * (i * i + k * k), 2 * (j * k + r * i)};
    const Vec3 z{2 * (i * k + r * j), 2 * (j * k - r * i), 1 - 2 * (i * i + j * j)};
    return {x * d.scale.x, x * d.skew_xy + y * d.scale.y,
            x * d.skew_xz + y * d.skew_yz + z * d.scale.z, d.translation};
}

Decomposed interpolate(const Decomposed& a, const Decomposed& b, float s) {
    const auto mixed = [s](float p, float q) { return p + (q - p) * s; };
    return {slerp(a.rotation, b.rotation, s), lerp(a.scale, b.scale, s),
            mixed(a.skew_xy, b.skew_xy),      mixed(a.skew_xz, b.skew_xz),
            mixed(a.skew_yz, b.skew_yz),      lerp(a.translation, b.translation, s)};
}

float angle_between(const Quaternion& a, const Quaternion& b) {
    return 2 * std::acos(std::min(1.0f, std::fabs(cosine(a, b))));
}

KeyedMotion::KeyedMotion(const std::vector<Affine>& keys) {
    const bool still = std::all_of(keys.begin(), keys.end(),
                                   [&](const Affine& key) { return key == keys.front(); });
    matrices_ = still ? std::vector<Affine>{keys.front()} : keys;
    if (still) return;
    for (const Affine& m : matrices_) {
        keys_.push_back(decompose(m));
        linear_ = linear_ && same_rotation(keys_.back().rotation, keys_.front().rotation);
    }
}

Affine KeyedMotion::between(size_t key, float part) const {
    if (part == 0) return matrices_[key];
    if (linear_) return lerp(matrices_[key], matrices_[key + 1], part);
    return compose(interpolate(keys_[key], keys_[key + 1], part));
}

Affine KeyedMotion::at(float time) const {
    if (!moving()) return matrices_[0];
    const float place = time * float(matrices_.size() - 1);
    const size_t key = std::min(size_t(std::max(place, 0.0f)), matrices_.size() - 2);
    return between(key, place - float(key));
}

}  // namespace weft::render
