// What light samples say of surfaces that their rays went past. Every light sample is a ray: where
// it meets a surface it says that something is there, and where it comes near one that others met
// and goes on it says that nothing is. A pass is such a place: a sample at the depth of the surface
// and with its motion, where the ray goes by. So hits and passes together tell a surface's very
// rim.
// Source: own; the question is the coverage of Lehtinen et al. 2011, Sec. 3.4.
// Cost: a search a sample, 2 to 4 us.  Memory: 28 bytes a sample while it runs, and the samples.
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

// The light samples, and behind them, in the order of blocks of the film, a pass for each ray and
// each surface that it passes. Channel `end` tells them apart: 0 a hit; of a pass, w of the ray's
// own hit.
//   hierarchy   of the light samples
//   density     light pixels a camera pixel of each camera sample; empty: 1
Samples with_passes(const Samples& light_samples, const Hierarchy& hierarchy,
                    std::span<const float> density, const LightView& view,
                    const PassingRays& settings, Context& ctx);

}  // namespace weft::shadows
