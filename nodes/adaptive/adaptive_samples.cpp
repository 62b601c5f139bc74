// adaptive-samples: samples where the picture, over all its axes, is not yet known:
// multidimensional adaptive sampling. Source: Hachisuka et al. 2008; rounds after Meister and
// Hachisuka 2022. See adaptive_tree.h. Departure: the scale of an axis is how far the picture moves
// over it, as the sampler says, not a user's guess.
#include "adaptive/adaptive_run.h"

namespace weft {
namespace {
using namespace adaptive;

struct AdaptiveSamples : AdaptiveSettings {
    static void declare(Ports<AdaptiveSamples>& node) {
        node.about(
                "samples a renderer where its picture varies over film, lens, time and light "
                "together")
            .in<SamplerFunction>("sampler", "what to sample; two to eight axes")
            .out<Samples>("samples",
                          "xy, uv and t as it has them, its other axes, rgb, features, weight: as "
                          "many a pixel as it took")
            .out<LeafTree>("leaves", "the boxes that the domain was cut into");
        declare_shared(node);
        declare_rounds(node);
        node.param(
            "seconds", static_cast<double AdaptiveSamples::*>(&AdaptiveSettings::seconds),
            {.unit = "s",
             .min = 0,
             .max = 1e6,
             .about = "of sampling, after which no further round is begun, whatever budget is "
                      "left: then a picture is no longer the same on another machine; 0: no "
                      "limit"});
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        sample_adaptively(in.get<SamplerFunction>("sampler"), *this, out, ctx);
    }
};

WEFT_NODE(AdaptiveSamples, "adaptive-samples", 4)

}  // namespace
}  // namespace weft
