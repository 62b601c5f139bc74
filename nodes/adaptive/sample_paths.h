// How a camera's samples move over the film, by time and lens: at time T, from lens position (u,
// v), a sample is seen at (X + (a u, v) C0) / w + (a u, v) C1, X and w linear in T, a the lens's
// aspect (docs/formats.md): a straight line in either.
#pragma once
#include <algorithm>
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

    // work(tile) for all tiles within `window` px of where sample i may be seen: at any time (or
    // its own), from anywhere on the lens (or its own place); tiles of `side` px, numbered row by
    // row.
    template <class Work>
    void cross(size_t i, float window, bool over_time, bool over_lens, int side, int across,
               int down, const Work& work) const {
        const bool centre = over_lens;
        const bool travels = over_time && moving();
        std::array<float, 3> a, b;
        if (!at(i, travels ? 0.0f : t(i), centre, a) && !at(i, t(i), centre, a)) return;
        if (!at(i, travels ? 1.0f : t(i), centre, b) && !at(i, t(i), centre, b)) return;
        const float aspect = std::max(lens_.aspect, 1.0f);
        const float pad =
            window + (centre ? aspect * std::max(std::abs(a[2]), std::abs(b[2])) : 0.0f);
        if (a[1] > b[1]) std::swap(a, b);
        if (!std::isfinite(a[0] + a[1] + b[0] + b[1] + pad)) return;
        const auto tile_of = [side](float where, int count) {
            return int(std::clamp(std::floor(where / float(side)), -1.0f, float(count)));
        };
        const int first = std::max(tile_of(a[1] - pad, down), 0),
                  last = std::min(tile_of(b[1] + pad, down), down - 1);
        const float rise = b[1] - a[1];
        for (int j = first; j <= last; ++j) {
            // The part of the path that comes near this row of tiles.
            float from = 0, to = 1;
            if (rise > 0) {
                from = std::clamp((float(j * side) - pad - a[1]) / rise, 0.0f, 1.0f);
                to = std::clamp((float((j + 1) * side) + pad - a[1]) / rise, 0.0f, 1.0f);
            }
            const float x0 = a[0] + (b[0] - a[0]) * from, x1 = a[0] + (b[0] - a[0]) * to;
            const int left = std::max(tile_of(std::min(x0, x1) - pad, across), 0),
                      right = std::min(tile_of(std::max(x0, x1) + pad, across), across - 1);
            for (int k = left; k <= right; ++k) work(size_t(j) * size_t(across) + size_t(k));
        }
    }

  private:
    std::span<const float> xy_, uv_, z_, t_, motion_;
    Lens lens_;
};

}  // namespace weft::adaptive
