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
            .in<Samples>("light-samples", "of the candidates, as of passing-rays")
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
        const Hierarchy& h = *candidates.hierarchy;
        const RayVoteAround around(h, in.get<Samples>("light-samples"),
                                   in.get<LightView>("light-view"), {test, bias});
        around.vote(candidates, queries, scratch, shares);
        around.widen(at, queries,
                     candidates.radius / std::max(light_field::largest_radius(h, at), 1e-30f),
                     max_widen, scratch, shares);
    }
};

WEFT_NODE(RayVoteCoverage, "ray-vote-coverage", 2)

}  // namespace
}  // namespace weft
