// How much of the light a receiver sees: the samples of the surface that lies between vote.
#pragma once
#include <span>

#include "light-field/streams.h"
#include "shadows/light_view.h"
#include "shadows/streams.h"

namespace weft::shadows {

// When a light sample's surface shadows a receiver.
enum class DepthTest {
    both_planes,    // it lies before the receiver by its own tangent plane and by the receiver's
    inverse_depth,  // by its own, inverse depth being linear over the film
    linear,         // by its own, depth taken for linear over the film (Lehtinen et al. 2011)
};

struct VoteSettings {
    DepthTest test = DepthTest::both_planes;
    float bias = 1e-5f;  // relative; linear: world units
    float tent = 1;      // R: where votes have no weight any more
    double c0x = 0, c0y = 0;
};

// The lit share of the votes of each location: candidates of the surface seen, weight 1 - d / R.
// None within R: the nearest decides.
//   gradient   dw/dx, dw/dy of each light sample, seen from l = 0, as `depth` is at its own time
//   depth      w of each light sample
// A plane is linear in 1/w over the film, from any point l: with slope h at l = 0 it has there
// h / (1 + C0 h.l). Where that divisor is below 0.1 it is seen edge-on and counts as level.
// Source: Lehtinen et al. 2011, Sec. 4.  Departures: inverse depth, in which planes are exact; the
// receiver's own plane, behind which a surface that bends away from the light never shadows itself.
void depth_vote(const Candidates& candidates, const Surfaces& surfaces,
                const Visibility& visibility, const ShadowQueries& queries,
                std::span<const float> gradient, std::span<const float> depth,
                const VoteSettings& settings, LightShares& out);

}  // namespace weft::shadows
