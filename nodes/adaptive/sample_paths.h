// How a camera's samples move over the film, by time and lens: at time T, from lens position (u,
// v), a sample is seen at (X + (a u, v) C0) / w + (a u, v) C1, X and w linear in T, a the lens's
// aspect (docs/formats.md): a straight line in either.
#pragma once
#include <array>
#include <cmath>

#include "samples/samples.h"

namespace weft::adaptive {

class SamplePaths {
  public:
    explicit SamplePaths(const Samples& samples)
        : xy_(samples.xy()), z_(samples.z()), lens_(samples.lens.value_or(Lens{})) {
        if (samples.has_lens()) uv_ = samples.uv();
        if (!samples.t().empty()) t_ = samples.t();
        if (samples.has_motion()) motion_ = samples.motion();
    }
    const Lens& lens() const { return lens_; }
    bool has_lens() const { return !uv_.empty(); }
    bool moving() const { return !motion_.empty(); }
    float x(size_t i) const { return xy_[2 * i]; }
    float y(size_t i) const { return xy_[2 * i + 1]; }
    float t(size_t i) const { return t_.empty() ? 0.5f : t_[i]; }
    // On the lens, the aspect taken in.
    std::array<float, 2> uv(size_t i) const {
        if (uv_.empty()) return {0, 0};
        return {uv_[2 * i] * lens_.aspect, uv_[2 * i + 1]};
    }
    // Radius of the circle of confusion, signed, at the sample's own time.
    float coc(size_t i) const {
        return uv_.empty() ? 0.0f : (z_[i] < INFINITY ? lens_.c0 / z_[i] : 0.0f) + lens_.c1;
    }
    // Speed over the film at the sample's own time and lens position, px a shutter.
    std::array<float, 2> velocity(size_t i) const {
        if (motion_.empty()) return {0, 0};
        const float w = depth(i), *m = &motion_[3 * i];
        const auto lens = uv(i);
        return {(m[0] - (x(i) - lens[0] * lens_.c1) * m[2]) / w,
                (m[1] - (y(i) - lens[1] * lens_.c1) * m[2]) / w};
    }
    // Change of (x w, y w, w) over the shutter, seen from the sample's own lens position.
    std::array<double, 3> homogeneous_motion(size_t i) const {
        if (motion_.empty()) return {0, 0, 0};
        const auto lens = uv(i);
        const double mw = double(motion_[3 * i + 2]);
        const double c1 = uv_.empty() ? 0 : double(lens_.c1);
        return {double(motion_[3 * i]) + double(lens[0]) * c1 * mw,
                double(motion_[3 * i + 1]) + double(lens[1]) * c1 * mw, mw};
    }
    float depth(size_t i) const { return z_[i] < INFINITY ? z_[i] : 1.0f; }
    // Where it is at another time: from its own lens position, or from the lens's centre; false
    // where it is behind the camera then.
    bool at(size_t i, float time, bool centre, std::array<float, 3>& x_y_coc) const {
        const float w = depth(i), dt = time - t(i);
        const auto own = uv(i);
        const bool far = !(z_[i] < INFINITY);  // whatever the lens position, by C1 alone
        const float c0 = far || uv_.empty() ? 0 : lens_.c0, c1 = uv_.empty() ? 0 : lens_.c1;
        const float coc_here = c0 / w + c1;
        float moved[3] = {(x(i) - own[0] * coc_here) * w, (y(i) - own[1] * coc_here) * w, w};
        if (!motion_.empty())
            for (size_t k = 0; k < 3; ++k) moved[k] += motion_[3 * i + k] * dt;
        if (!(moved[2] > 0.02f * w)) return false;
        const float coc_there = c0 / moved[2] + c1;
        x_y_coc = {moved[0] / moved[2], moved[1] / moved[2], coc_there};
        if (!centre) x_y_coc[0] += own[0] * coc_there, x_y_coc[1] += own[1] * coc_there;
        return true;
    }

  private:
    std::span<const float> xy_, uv_, z_, t_, motion_;
    Lens lens_;
};

}  // namespace weft::adaptive
