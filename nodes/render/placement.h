// Placement: where a thing that rays can meet stands over the shutter, in straight steps.
//   matrices  at equal steps of time in [0, 1], interpolated entry by entry: what is cheap to bound
//             and to trace, and the same in Embree, in shading and in `motion`
//   steps     what lies between keys (keyed_motion.h) stays within `straight_enough` of the largest
//             axis; keys themselves are met exactly
//   pieces    equal parts of the shutter, a power of two, each of at most `most_steps` steps
#pragma once
#include <vector>

#include "render/affine.h"

namespace weft::render {

class Placement {
  public:
    // A thing of 500 pixels' radius is off by half a pixel at most, halfway between steps.
    static constexpr float straight_enough = 1.0f / 1000;
    static constexpr size_t most_steps = most_motion_keys - 1;

    Placement() : Placement(std::vector<Affine>{Affine{}}) {}
    // 1 to most_motion_keys keys, finite and invertible.
    explicit Placement(const std::vector<Affine>& keys);

    bool moving() const { return matrices_.size() > 1; }
    const std::vector<Affine>& matrices() const { return matrices_; }
    size_t pieces() const { return pieces_; }
    size_t steps_a_piece() const { return (matrices_.size() - 1) / pieces_; }
    Affine at(float time) const;

  private:
    std::vector<Affine> matrices_;
    size_t pieces_ = 1;
};

// A ball of light looks the same from everywhere: its rotation, which straight steps would squash
// it by, is left out.
Placement placement_of(const Light& light);

}  // namespace weft::render
