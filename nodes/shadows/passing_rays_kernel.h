// What light samples say of surfaces that their rays went past. Every light sample is a ray: where
// it meets a surface it says that something is there, and where it comes near one that others met
// and goes on it says that nothing is. A pass is such a place: a sample at the depth of the surface
// and with its motion, where the ray goes by. So hits and passes together tell a surface's very
// rim.
// Source: own; the question is the coverage of Lehtinen et al. 2011, Sec. 3.4.
// Cost: a search a sample, 2 to 4 us.  Memory: 4 bytes a sample and 12 a pass while it runs.
#pragma once
#include <span>

#include "light-field/hierarchy.h"
#include "runtime/context.h"
#include "shadows/light_view.h"

namespace weft::shadows {

struct PassingRays {
    float radius_scale = 2;  // R: how near to a surface's samples a ray passes it
    float bias = 1e-5f;      // relative depth: what stands nearer before a hit is that surface
};

// A light sample for each ray and each surface that it passes, in the order of blocks of the film:
// where and when the ray was sent, as deep as the surface, moving and tilted as it does; channel
// `end` is w of the ray's own hit; `bulge`, px, how far a surface that bends may come out beside it
// as it is seen from points of the light that are an angle of 1 away: half the surface's radius.
//   hits      of the light samples
//   density   light pixels a camera pixel of each camera sample; empty: 1
//   clear     R around each camera sample in which nothing stands before it: its ray passes nothing
//             there (lit_receivers.cpp); empty: not known
Samples passes(const Hierarchy& hits, std::span<const float> density,
               std::span<const float> clear, const LightView& view, const PassingRays& settings,
               Context& ctx);

}  // namespace weft::shadows
