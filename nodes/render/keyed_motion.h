// KeyedMotion: where something stands over the shutter, from a transform or several at equal steps
// of time in [0, 1]. Between keys the rotation goes by spherical interpolation, scale, skew and
// translation linearly.
// Source: M = T R S with S upper triangular (Gram-Schmidt on M's columns); Shoemake 1985.
#pragma once
#include <vector>

#include "render/affine.h"

namespace weft::render {

struct Quaternion {
    float r = 1, i = 0, j = 0, k = 0;
    bool operator==(const Quaternion&) const = default;
};

struct Decomposed {
    Quaternion rotation;
    Vec3 scale{1, 1, 1};
    float skew_xy = 0, skew_xz = 0, skew_yz = 0;
    Vec3 translation;
};

// Needs a transform whose inverse exists (see is_invertible).
Decomposed decompose(const Affine& transform);
Affine compose(const Decomposed& parts);
Decomposed interpolate(const Decomposed& a, const Decomposed& b, float s);
// Radians that the interpolation turns by, at most pi.
float angle_between(const Quaternion& a, const Quaternion& b);

class KeyedMotion {
  public:
    KeyedMotion() : KeyedMotion(std::vector<Affine>{Affine{}}) {}
    // One key or more, finite and invertible.
    explicit KeyedMotion(const std::vector<Affine>& keys);

    bool moving() const { return matrices_.size() > 1; }
    const std::vector<Affine>& matrices() const { return matrices_; }  // one where nothing moves
    const std::vector<Decomposed>& parts() const { return keys_; }     // of each; none likewise
    Affine at(float time) const;
    // A part in [0, 1) of the way from one key to the next.
    Affine between(size_t key, float part) const;

  private:
    std::vector<Affine> matrices_;
    std::vector<Decomposed> keys_;
    // Keys differ by scale, skew and translation only: matrices may be interpolated as they are.
    bool linear_ = true;
};

}  // namespace weft::render
