// A camera's sample buffer as light views read it: where each sample lies, homogeneous, at both
// ends of the shutter (docs/formats.md: `motion`).
#pragma once
#include <array>
#include <cmath>

#include "shadows/light_view.h"

namespace weft::shadows {

class CameraSamples {
  public:
    explicit CameraSamples(const Samples& samples)
        : xy_(samples.xy()), z_(samples.z()), lens_(samples.lens.value_or(Lens{})) {
        if (samples.has_lens()) uv_ = samples.uv();
        if (!samples.t().empty()) t_ = samples.t();
        if (samples.has_motion()) motion_ = samples.motion();
    }
    bool hit(size_t i) const { return z_[i] > 0 && z_[i] < INFINITY; }
    double time(size_t i) const { return t_.empty() ? 0.5 : double(t_[i]); }
    // At the opening and at the close, seen from the lens centre.
    std::array<Point3, 2> ends(size_t i) const {
        const double z = double(z_[i]);
        double x = double(xy_[2 * i]), y = double(xy_[2 * i + 1]);
        if (!uv_.empty()) {
            const double c = double(lens_.c0) / z + double(lens_.c1);
            x -= c * double(lens_.aspect) * double(uv_[2 * i]);
            y -= c * double(uv_[2 * i + 1]);
        }
        const Point3 here{x * z, y * z, z};
        if (motion_.empty()) return {here, here};
        const Point3 way{double(motion_[3 * i]), double(motion_[3 * i + 1]),
                         double(motion_[3 * i + 2])};
        const Point3 open = here - way * time(i);
        return {open, open + way};
    }

  private:
    std::span<const float> xy_, uv_, z_, t_, motion_;
    Lens lens_;
};

}  // namespace weft::shadows
