// ray-vote-coverage: how much of the light each location sees, by the rays that came near
// (ray_vote_kernel.h). Where none did, it looks farther around.
#include "runtime/node.h"
#include "shadows/ray_vote_around.h"

namespace weft {
namespace {
using namespace shadows;

struct RayVoteCoverage {
    DepthTest test = DepthTest::both_planes;
    float bias = 1e-5f;
    int max_widen = 3;

    static void declare(Ports<RayVoteCoverage>& node) {
        node.about(
                "whether light reaches each location: it does where a ray that goes on comes "
                "nearer than those that were stopped")
            .in<Locations>("locations", "on the light's film")
            .in<Candidates>("candidates", "the light samples near each location")
            .in<ShadowQueries>("queries", "the receivers")
            .in<Hierarchy>("passes", "of what passing-rays found of the same light samples")
            .in<LightView>("light-view", "of the light samples")
            .out<LightShares>("shares",
                              "1 where light arrives, 0 where not; 1 where no ray is near")
            .choice("test", &RayVoteCoverage::test, {"both-planes", "inverse-depth", "linear"},
                    {.about = "when a surface stands before a receiver, as of depth-vote"})
            .param("bias", &RayVoteCoverage::bias,
                   {.min = 0,
                    .max = 1e6,
                    .about = "of the depth, how much nearer to the light than the receiver is not "
                             "nearer yet; of test linear in world units (published: 0.01)"})
            .param("max-widen", &RayVoteCoverage::max_widen,
                   {.min = 0,
                    .max = 8,
                    .about = "how often the radius is doubled where no ray is near"});
    }
    using Scratch = RayVoteAround::Scratch;
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Candidates& candidates = in.get<Candidates>("candidates");
        const ShadowQueries& queries = in.get<ShadowQueries>("queries");
        const Locations& at = in.get<Locations>("locations");
        LightShares& shares = out.get<LightShares>("shares");
        const Hierarchy& hits = *candidates.hierarchy;
        const RayVoteAround around(hits, in.get<Hierarchy>("passes"),
                                   in.get<LightView>("light-view"), {test, bias});
        const float scale =
            candidates.radius / std::max(light_field::largest_radius(hits, at), 1e-30f);
        around.vote(candidates, at, queries, scale, 1, scratch, shares);
        around.widen(at, queries, scale, max_widen, scratch, shares);
    }
};

WEFT_NODE(RayVoteCoverage, "ray-vote-coverage", 4)

}  // namespace
}  // namespace weft
