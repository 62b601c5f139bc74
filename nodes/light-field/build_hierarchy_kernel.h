// Building a Hierarchy: samples are carried to lens centre and half time, sorted, put in place and
// bounded. Source: Lehtinen et al. 2011, Sec. 3.2 and Appendix A (see hierarchy.h). Cost: linear in
// samples.  Memory: 48 bytes a sample, all of them the result's; 12 while keys are sorted. Threads:
// through the context.
#pragma once
#include <span>

#include "light-field/hierarchy.h"
#include "runtime/context.h"

namespace weft::light_field {

// Homogeneous depth that stands for infinity: far enough that its slope is C1 to the last bit.
inline constexpr float far_depth = 0x1p+40f;

// Radius of the largest empty disk that a good sampling pattern of this density leaves, px.
// Source: 2.2 / sqrt(spp + 0.2) is within 10 % of what the authors of the method measured, from 1
// to 256 samples a pixel.
float dispersion_radius(double samples_per_pixel);

struct Recentred {
    float X, Y, W, VX, VY, VW;
};
// Of sample i of a buffer with xy and z. A sample at infinity becomes a point far_depth away.
class Recentring {
  public:
    explicit Recentring(const Samples& samples);
    Recentred operator()(size_t i) const;
    // Has the sample fetched, for soon.
    void prefetch(size_t i) const {
        __builtin_prefetch(&xy[2 * i]);
        __builtin_prefetch(&z[i]);
        if (!uv.empty()) __builtin_prefetch(&uv[2 * i]);
        if (motion.empty()) return;
        __builtin_prefetch(&motion[3 * i]);
        __builtin_prefetch(&t[i]);
    }

  private:
    std::span<const float> xy, uv, t, z, motion;
    Lens lens;
};
Recentred recentred(const Samples& samples, size_t i);

// Whether the sample is in front of the camera during the whole shutter.
inline bool always_there(float W, float VW) {
    const float half = 0.5f * (VW < 0 ? -VW : VW);
    return W - half > 1e-6f * half && W > 0;
}

enum class Arrangement {
    layers,  // blocks of about 48 samples along a Morton curve, each sorted by slope and velocity
    cells,   // uniform square cells of about 16 samples, row by row, depth left out of account
};

// Everything: `samples` with xy, z and rgb at least.
Hierarchy build_hierarchy(const Samples& samples, Arrangement arrangement, double radius_scale,
                          Context& ctx);

}  // namespace weft::light_field
