// Light samples: what the light sees of the scene, a Samples value of domain "light"
// (docs/formats.md):
//   xy, uv        q, px of the light view's film as seen from the sample's own l, and l
//   t, z          time; w, the distance in front of the light
//   motion        homogeneous, px w and w; present where something moves
//   z_gradient    dw/dx, dw/dy of the surface, as seen from l = 0; 0: not known, or edge-on
//   source        the camera sample whose shadow ray it is
// Source: Lehtinen et al. 2011, Sec. 4.  Departure: the sample is the first thing that the light
// sees along a camera sample's own shadow ray, from a point of the light of its own.
#pragma once
#include <atomic>
#include <cmath>
#include <cstdint>
#include <vector>

#include "runtime/context.h"
#include "samples/samplers.h"
#include "shadows/light_view.h"

namespace weft::shadows {

// The first thing that the light sees along a ray, in light space.
struct LightHit {
    Point3 at, motion;  // at the sample's time; over the shutter
    Point3 normal;      // 0: not known
    double t = 0.5, lx = 0, ly = 0;
    std::uint32_t source = 0;
    bool stopped = false;  // by something before the receiver
};

// Receivers that have no light sample.
struct Unseen {
    size_t too_near = 0;  // they, or what shadows them, touch the light
    size_t outside = 0;   // the light shines on them, but its view does not hold them
    size_t rays = 0, stopped = 0;  // all that were sent, and those that did not get there
};
// Sums of several threads.
class UnseenOfAll {
  public:
    void operator+=(const Unseen& more) {
        too_near_ += more.too_near, outside_ += more.outside;
        rays_ += more.rays, stopped_ += more.stopped;
    }
    operator Unseen() const { return {too_near_, outside_, rays_, stopped_}; }

  private:
    std::atomic<size_t> too_near_ = 0, outside_ = 0, rays_ = 0, stopped_ = 0;
};
void warn_of(const Unseen& unseen, const LightView& view, Context& ctx);

// Samples in places of their own, some of them empty. Threads: any, on different places.
class LightSampleArrays {
  public:
    explicit LightSampleArrays(size_t places);
    void set(size_t place, const LightView& view, const LightHit& hit);
    // Whether `hit` can be: in front of the light, on its film, all numbers finite; counts it where
    // not.
    static bool seen(const LightView& view, const LightHit& hit, Unseen& unseen);
    // The places that were set, in order. `part` of the camera's samples asked this light at all.
    Samples take(const LightView& view, const Samples& camera, double part = 1) &&;

  private:
    std::vector<float> xy_, uv_, t_, z_, motion_, gradient_;
    std::vector<std::uint32_t> source_;
};

// Two numbers in [0, 1) for the light's point of sample `index` of a pixel that has `count`.
Disk light_numbers(std::uint64_t seed, int x, int y, int count, std::uint32_t index);

}  // namespace weft::shadows
