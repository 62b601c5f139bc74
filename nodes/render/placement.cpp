#include "render/placement.h"

#include <algorithm>
#include <cassert>

#include "render/keyed_motion.h"

namespace weft::render {
namespace {

// Straight steps from key to key that keep the axes' ends within `tolerance` of the largest axis.
// A chord lies within h^2 / 8 max |f''| of its arc of length h; with f = R S, S linear, the second
// derivative of an axis is at most angle^2 |S| + 2 angle |S'|.
size_t steps_a_key(const KeyedMotion& motion, float tolerance) {
    float size = 0;
    for (const Affine& m : motion.matrices())
        size = std::max({size, length(m.x), length(m.y), length(m.z)});
    float worst = 0;
    for (size_t k = 0; k + 1 < motion.parts().size(); ++k) {
        const Decomposed &a = motion.parts()[k], &b = motion.parts()[k + 1];
        const float angle = angle_between(a.rotation, b.rotation);
        const Vec3 scale = b.scale - a.scale;
        const float xy = b.skew_xy - a.skew_xy, xz = b.skew_xz - a.skew_xz,
                    yz = b.skew_yz - a.skew_yz;
        const float change =
            std::max({std::fabs(scale.x), std::hypot(xy, scale.y), length(Vec3{xz, yz, scale.z})});
        worst = std::max(worst, angle * (angle + 2 * change / size) / 8);
    }
    return std::max<size_t>(1, size_t(std::ceil(std::sqrt(worst / tolerance))));
}

}  // namespace

Placement::Placement(const std::vector<Affine>& keys) {
    assert(!keys.empty() && keys.size() <= most_motion_keys);
    const KeyedMotion motion(keys);
    matrices_ = motion.matrices();
    if (!moving()) return;
    const size_t intervals = matrices_.size() - 1;
    size_t steps = steps_a_key(motion, straight_enough);
    // Pieces of equal length, each of whole steps.
    while (intervals * steps > pieces_ * most_steps) {
        pieces_ *= 2;
        steps = (steps + pieces_ - 1) / pieces_ * pieces_;
    }
    if (steps == 1) return;
    matrices_.clear();
    for (size_t i = 0; i < intervals * steps; ++i)
        matrices_.push_back(motion.between(i / steps, float(i % steps) / float(steps)));
    matrices_.push_back(motion.matrices().back());
}

Affine Placement::at(float time) const {
    if (!moving()) return matrices_[0];
    // In this order, as Embree has it: both find the same place between the same two matrices.
    const size_t steps = steps_a_piece();
    const float in_pieces = std::max(time, 0.0f) * float(pieces_);
    const size_t piece = std::min(size_t(in_pieces), pieces_ - 1);
    const float place = (in_pieces - float(piece)) * float(steps);
    const size_t step = std::min(size_t(place), steps - 1), i = piece * steps + step;
    return lerp(matrices_[i], matrices_[i + 1], place - float(step));
}

Placement placement_of(const Light& light) {
    if (light.shape != Light::Shape::sphere) return Placement(light.to_world);
    std::vector<Affine> keys;
    for (const Affine& m : light.to_world) keys.push_back(translate(m.origin) * scale(length(m.x)));
    return Placement(keys);
}

}  // namespace weft::render
