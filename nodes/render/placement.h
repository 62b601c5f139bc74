// Placement: where something stands over the shutter, from a transform or several at equal steps of
// time in [0, 1]. Between keys the rotation goes by spherical interpolation, scale, skew and
// translation linearly, which is what Embree's quaternion motion does.
// Source: M = T R S with S upper triangular (Gram-Schmidt on M's columns); Shoemake 1985.
#pragma once
#include <string>
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

bool is_invertible(const Affine& transform);
Affine inverse(const Affine& transform);
// Normals go by the transposed inverse; not unit.
Vec3 transformed_normal(const Affine& transform, Vec3 normal);

class Placement {
  public:
    Placement() : Placement(std::vector<Affine>{Affine{}}) {}
    // One key or more, finite and invertible.
    explicit Placement(const std::vector<Affine>& keys);

    bool moving() const { return keys_.size() > 1; }
    // Keys differ by scale, skew and translation only: matrices may be interpolated as they are.
    bool linear() const { return linear_; }
    const std::vector<Decomposed>& keys() const { return keys_; }
    const std::vector<Affine>& matrices() const { return matrices_; }
    Affine at(float time) const;

  private:
    std::vector<Affine> matrices_;
    std::vector<Decomposed> keys_;
    bool linear_ = true;
};

}  // namespace weft::render
