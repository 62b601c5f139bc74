// How much of the light a receiver sees: the samples of the surface that lies between vote.
#pragma once
#include "light-field/streams.h"
#include "shadows/planes.h"
#include "shadows/streams.h"

namespace weft::shadows {

struct VoteSettings {
    DepthTest test = DepthTest::both_planes;
    float bias = 1e-5f;  // relative; linear: world units
    float tent = 1;      // R: where votes have no weight any more
};

// The lit share of the votes of each location: candidates of the surface seen, weight 1 - d / R.
// None within R: the nearest decides.
// Source: Lehtinen et al. 2011, Sec. 4; planes.h tells where we differ.
void depth_vote(const Candidates& candidates, const Surfaces& surfaces,
                const Visibility& visibility, const ShadowQueries& queries, const Planes& planes,
                const VoteSettings& settings, LightShares& out);

}  // namespace weft::shadows
