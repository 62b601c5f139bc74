// soft-shadow-z-reconstruct: locate-receivers, reproject and ray-vote-coverage as one kernel
// (light_vote_kernel.h), in which what is known of a receiver is worked out once for all locations
// that see it, and light samples near it never leave the cache of its core.
#include "runtime/fusion.h"
#include "shadows/light_vote_kernel.h"
#include "shadows/ray_vote_around.h"
#include "shadows/receivers.h"

namespace weft::shadows {
namespace {

struct SoftShadowZReconstruct {
    std::uint64_t seed = 1;
    float search = 1, bias = 0;
    int max_widen = 0;
    DepthTest test = DepthTest::both_planes;
    Nearness metric = Nearness::round;

    static void declare(Fusing<SoftShadowZReconstruct>& fusing) {
        using This = SoftShadowZReconstruct;
        fusing
            .about(
                "finds where the receiver of each location stands before the light, and whether "
                "rays that came near it were stopped")
            .part("locate-receivers")
            .part("reproject")
            .part("ray-vote-coverage")
            .inner("locate-receivers.locations",
                   {"reproject.locations", "ray-vote-coverage.locations"})
            .inner("locate-receivers.queries", {"ray-vote-coverage.queries"})
            .inner("reproject.candidates", {"ray-vote-coverage.candidates"})
            .in("locations", {"locate-receivers.locations"})
            .in("seen", {"locate-receivers.seen"})
            .in("hierarchy", {"locate-receivers.hierarchy"})
            .in("samples", {"locate-receivers.samples"})
            .in("light-view", {"locate-receivers.light-view", "ray-vote-coverage.light-view"})
            .in("hits", {"reproject.hierarchy"})
            .in("passes", {"ray-vote-coverage.passes"})
            .out("queries", "locate-receivers.queries")
            .out("shares", "ray-vote-coverage.shares")
            .param("locate-receivers.seed", &This::seed)
            .param("locate-receivers.metric", &This::metric)
            .param("reproject.radius-scale", &This::search)
            .param("ray-vote-coverage.bias", &This::bias)
            .param("ray-vote-coverage.test", &This::test)
            .param("ray-vote-coverage.max-widen", &This::max_widen);
    }
    bool suits() const {
        return test == DepthTest::both_planes && search == 1 && metric == Nearness::round;
    }

    // Those of a tile's samples, which are few runs of the hierarchy's order.
    class HeldReceivers {
      public:
        void start(const Receivers& all, const Hierarchy& camera) {
            all_ = &all;
            if (of_ == &camera) return;
            of_ = &camera;
            receivers_.resize(size);
            held_.assign(size, SeenSamples::none);
        }
        const Receiver& operator()(std::uint32_t sample) {
            const size_t place = sample % size;
            if (held_[place] != sample)
                held_[place] = sample, receivers_[place] = all_->of(sample);
            return receivers_[place];
        }
        void fetch(std::uint32_t sample) const { __builtin_prefetch(&receivers_[sample % size]); }

      private:
        static constexpr size_t size = 32768;
        std::vector<Receiver> receivers_;
        std::vector<std::uint32_t> held_;  // whose they are
        const Hierarchy* of_ = nullptr;
        const Receivers* all_ = nullptr;
    };
    struct Scratch {
        HeldReceivers held;
        ReceiverBatch batch;
        Locations at;
        ShadowQueries unread;
        LightVoteScratch vote;
        RayVoteAround::Scratch around;
    };

    void batch(const Inputs& in, Outputs& out, Scratch& s) const {
        const Hierarchy& camera = in.get<Hierarchy>("hierarchy");
        const Hierarchy& hits = in.get<Hierarchy>("hits");
        const Hierarchy& passes = in.get<Hierarchy>("passes");
        const LightView& view = in.get<LightView>("light-view");
        const Locations& from = in.get<Locations>("locations");
        ShadowQueries& queries =
            out.wanted("queries") ? out.get<ShadowQueries>("queries") : s.unread;
        LightShares& shares = out.get<LightShares>("shares");
        s.at.pixels = from.pixels, s.at.parents = from.parents;
        const Receivers receivers(camera, in.get<Samples>("samples"), view);
        s.held.start(receivers, camera);
        const SeenSamples& seen = in.get<SeenSamples>("seen");
        queries.chance = seen.chance;
        receivers.locate(seed, from, seen.sample, s.held, s.batch, s.at, queries);
        const RayVoteAround around(hits, passes, view, {test, bias});
        if (s.at.shared)
            WEFT_PICK(light_vote)(hits, passes, view, s.at, queries, bias, s.vote, shares);
        else
            around.look(s.at, queries, search, search, s.around, shares);
        around.widen(s.at, queries, search, max_widen, s.around, shares);
    }
};

WEFT_FUSION(SoftShadowZReconstruct, "soft-shadow-z-reconstruct")

}  // namespace
}  // namespace weft::shadows
