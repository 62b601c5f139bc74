// How much of the light a receiver sees: by the rays that came near.
#pragma once
#include <vector>

#include "light-field/streams.h"
#include "shadows/planes.h"
#include "shadows/streams.h"

namespace weft::shadows {

struct RayVote {
    DepthTest test = DepthTest::both_planes;
    float bias = 1e-5f;  // relative; linear: world units
};

struct RayVoteScratch {
    // A ray that passed something before the receiver, as seen from the light's point.
    struct Pass {
        float x, y, inverse;  // px from the receiver, and 1/w there
        float way_x, way_y;   // px it moves a unit of 1/w
        float end;            // 1/w where it ends
    };
    std::vector<std::uint32_t> hits;
    std::vector<Pass> passes;
};

// A receiver does not see the light's point if a ray was stopped on its way that comes nearer to it
// there than all rays that are free of what stopped it: that go by where that surface is, and on.
// So rims lie in the middle between the last ray that was stopped and the first that went past;
// over many points of the light this is the share of rays that a surface lets through.
//   end   of each light sample 0 where a ray was stopped, else how deep the ray got that passed it
//         (passing_rays_kernel.h); empty: all were stopped
// Where nobody is near, the share is 1 and nobody has voted.
// Source: own, in place of the coverage of Lehtinen et al. 2011, Sec. 3.4 and 4.
void ray_vote(const Candidates& candidates, const ShadowQueries& queries, const Planes& planes,
              std::span<const float> end, const RayVote& settings, RayVoteScratch& scratch,
              LightShares& out);

}  // namespace weft::shadows
