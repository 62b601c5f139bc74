// probability-samples: adaptive sampling in which every box gets a sample by chance, the likelier
// the larger its error is. Source: Meister and Hachisuka 2022; first cells are a grid of powers of
// two, as there. Departure: x and y get as many more bits as a sample a pixel allows, not always 8.
#include "adaptive/adaptive_run.h"

namespace weft {
namespace {
using namespace adaptive;

struct ProbabilitySamples : AdaptiveSettings {
    ProbabilitySamples() { alpha = 0.25, bits = 1; }

    static void declare(Ports<ProbabilitySamples>& node) {
        node.about(
                "samples a renderer where its picture varies, each box by chance: "
                "adaptive-samples as it fits many processors at once")
            .in<SamplerFunction>("sampler", "what to sample; two to eight axes")
            .out<Samples>("samples", "as of adaptive-samples")
            .out<LeafTree>("leaves", "the boxes that the domain was cut into");
        declare_shared(node);
        node.param("alpha", static_cast<double ProbabilitySamples::*>(&AdaptiveSettings::alpha),
                   {.min = 1e-3,
                    .max = 16,
                    .about = "a box gets a sample with probability (error / largest error)^alpha"})
            .param("bits-per-dim", static_cast<int ProbabilitySamples::*>(&AdaptiveSettings::bits),
                   {.min = 0, .max = 8, .about = "first cells along an axis, as a power of two"})
            .param("extra-image-bits",
                   static_cast<int ProbabilitySamples::*>(&AdaptiveSettings::extra_bits),
                   {.min = -1,
                    .max = 14,
                    .about = "more bits along x and y; -1: as many as first cells of about a "
                             "sample a pixel allow"});
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        sample_adaptively(in.get<SamplerFunction>("sampler"), *this, out, ctx);
    }
};

WEFT_NODE(ProbabilitySamples, "probability-samples", 4)

}  // namespace
}  // namespace weft
