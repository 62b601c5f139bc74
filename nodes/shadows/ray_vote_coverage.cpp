// ray-vote-coverage: how much of the light each location sees, by the rays that came near
// (ray_vote_kernel.h). Where none did, it looks farther around.
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/local_radius.h"
#include "light-field/projected.h"
#include "runtime/node.h"
#include "shadows/ray_vote_kernel.h"

namespace weft {
namespace {
using namespace shadows;
using namespace light_field;

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
    struct Scratch {
        RayVoteScratch vote;
        light_field::Block block;
        Locations at;
        Candidates found;
        ShadowQueries queries;
        LightShares shares;
    };
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Samples& lights = in.get<Samples>("light-samples");
        const Candidates& candidates = in.get<Candidates>("candidates");
        const ShadowQueries& queries = in.get<ShadowQueries>("queries");
        const Locations& at = in.get<Locations>("locations");
        LightShares& shares = out.get<LightShares>("shares");
        const Planes planes(*candidates.hierarchy, lights.values("z_gradient"), lights.z(),
                            in.get<LightView>("light-view"));
        const auto end = lights.values("end");
        ray_vote(candidates, queries, planes, end, {test, bias}, scratch.vote, shares);
        const float first =
            candidates.radius / std::max(largest_radius(planes.hierarchy(), at), 1e-30f);
        for (int k = 1; k <= max_widen; ++k) {
            if (!take_lonely(at, queries, shares, scratch)) return;
            const float scale = std::ldexp(first, k);
            look(planes.hierarchy(), scale, scratch);
            ray_vote(scratch.found, scratch.queries, planes, end, {test, bias}, scratch.vote,
                     scratch.shares);
            for (size_t i = 0; i < scratch.at.size(); ++i) {
                const std::uint32_t l = scratch.at.own_parents[i];
                shares.share[l] = scratch.shares.share[i];
                shares.votes[l] = scratch.shares.votes[i];
            }
        }
    }

  private:
    // Those that were asked for and found no ray; false if there are none.
    static bool take_lonely(const Locations& at, const ShadowQueries& queries,
                            const LightShares& shares, Scratch& s) {
        Locations& to = s.at;
        for (auto* values : {&to.x, &to.y, &to.u, &to.v, &to.t, &to.ratio, &s.queries.inverse_depth,
                             &s.queries.slope_x, &s.queries.slope_y})
            values->clear();
        to.own_pixels.clear(), to.own_parents.clear();
        to.shared = false;
        to.x0 = at.x0, to.y0 = at.y0, to.x1 = at.x1, to.y1 = at.y1;
        for (size_t l = 0; l < at.size(); ++l) {
            if (shares.votes[l] > 0 || !(queries.inverse_depth[l] > 0)) continue;
            to.x.push_back(at.x[l]), to.y.push_back(at.y[l]);
            to.u.push_back(at.u_of(l)), to.v.push_back(at.v_of(l)), to.t.push_back(at.t_of(l));
            if (!at.ratio.empty()) to.ratio.push_back(at.ratio[l]);
            to.own_pixels.push_back(at.pixels[l]);
            to.own_parents.push_back(std::uint32_t(l));
            s.queries.inverse_depth.push_back(queries.inverse_depth[l]);
            s.queries.slope_x.push_back(queries.slope_x[l]);
            s.queries.slope_y.push_back(queries.slope_y[l]);
        }
        to.pixels = to.own_pixels;
        return to.size() > 0;
    }
    static void look(const Hierarchy& h, float scale, Scratch& s) {
        const float radius = scale * largest_radius(h, s.at);
        collect_for(h, s.at, radius, s.block);
        for (Batch* batch : std::initializer_list<Batch*>{&s.found, &s.shares})
            batch->pixels = s.at.pixels;
        WEFT_PICK(gather_each)(h, s.block, s.at, radius, s.found);
        narrow(scale, s.at, s.found);
    }
};

WEFT_NODE(RayVoteCoverage, "ray-vote-coverage", 1)

}  // namespace
}  // namespace weft
