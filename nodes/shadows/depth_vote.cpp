// depth-vote: how much of the light each location sees, by vote of the light samples of the surface
// that lies between (depth_vote_kernel.h).
#include "runtime/node.h"
#include "shadows/depth_vote_kernel.h"

namespace weft {
namespace {
using namespace shadows;

struct DepthVote {
    DepthTest test = DepthTest::both_planes;
    float bias = 1e-5f, radius_scale = 1;

    static void declare(Ports<DepthVote>& node) {
        node.about("the lit share of the votes of the light samples near each location")
            .in<Candidates>("candidates", "the light samples near each location")
            .in<Surfaces>("surfaces", "their surfaces, nearest to the light first")
            .in<Visibility>("visibility", "the surface that the light meets on its way")
            .in<ShadowQueries>("queries", "the receivers")
            .in<LightView>("light-view", "of the light samples")
            .out<LightShares>(
                "shares", "how much of the light each location sees; all of it where nobody votes")
            .choice("test", &DepthVote::test, {"both-planes", "inverse-depth", "linear"},
                    {.about = "when a sample's surface shadows a receiver. both-planes: it lies "
                              "before it by the tangent planes of "
                              "both; inverse-depth: by its own, as planes are seen; linear: by its "
                              "own, as published, depth taken for linear"})
            .param("bias", &DepthVote::bias,
                   {.min = 0,
                    .max = 1e6,
                    .about = "of the depth, how much nearer to the light than the receiver is not "
                             "nearer yet; of test linear in world units (published: 0.01)"})
            .param("radius-scale", &DepthVote::radius_scale,
                   {.unit = "R",
                    .min = 0.05,
                    .max = 32,
                    .about = "where votes have no weight any more"});
    }
    void batch(const Inputs& in, Outputs& out) const {
        const LightView& view = in.get<LightView>("light-view");
        const Candidates& candidates = in.get<Candidates>("candidates");
        depth_vote(candidates, in.get<Surfaces>("surfaces"), in.get<Visibility>("visibility"),
                   in.get<ShadowQueries>("queries"),
                   {*candidates.hierarchy, view},
                   {test, bias, radius_scale}, out.get<LightShares>("shares"));
    }
};

WEFT_NODE(DepthVote, "depth-vote", 4)

}  // namespace
}  // namespace weft
