// adaptive-begin, adaptive-step, adaptive-end: adaptive-samples in pieces, for renderers that no
// node can call: a farm's, or a program of somebody else's. Written with write-samples and read
// with read-samples, state and requests outlive a run.
//   begin -> state, requests;  step: state, results -> state, requests ...;  end: state -> samples
#include "adaptive/adaptive_steps.h"
#include "adaptive/sampler_shape.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

template <class Node>
void declare_outputs(Ports<Node>& node) {
    node.template out<Samples>("state", "what was sampled so far, and the settings")
        .template out<Samples>("requests",
                               "points to render: xy, uv, t ..., 'point' in [0, 1], 'request' "
                               "numbers; none: it is done");
}
void hand_out(const AdaptiveSteps& steps, Outputs& out) {
    if (out.wanted("state")) out.set("state", steps.state());
    if (out.wanted("requests")) out.set("requests", steps.requests());
}

struct AdaptiveBegin : AdaptiveSettings, SamplerShape {
    static void declare(Ports<AdaptiveBegin>& node) {
        node.about("begins an adaptive sampling of a renderer that is not called but asked")
            .in<SamplerFunction>("sampler", "size and axes are its own, not the parameters'",
                                 Need::optional);
        declare_outputs(node);
        declare_shape(node);
        declare_shared(node);
        declare_rounds(node);
    }
    void run(const Inputs& in, Outputs& out, Context&) const {
        AdaptiveSetup setup;
        setup.settings = *this;
        if (const auto* sampler = in.find<SamplerFunction>("sampler")) {
            setup.sampler = *sampler;
            setup.sampler.evaluate = nullptr;
            setup.sampler.features.clear();
        } else {
            setup.sampler = SamplerShape::sampler();
        }
        hand_out(AdaptiveSteps(std::move(setup)), out);
    }
};

struct AdaptiveStep {
    static void declare(Ports<AdaptiveStep>& node) {
        node.about("takes rendered requests and asks for those of the next round")
            .in<Samples>("state", "of adaptive-begin, or of the step before")
            .in<Samples>("results",
                         "its requests, rendered: rgb, 'request', and any features; in any order");
        declare_outputs(node);
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        AdaptiveSteps steps(in.get<Samples>("state"));
        steps.take(in.get<Samples>("results"));
        steps.run().judge(ctx);
        ctx.progress(double(steps.run().samples()), double(steps.budget()), "samples");
        hand_out(steps, out);
    }
};

struct AdaptiveEnd {
    static void declare(Ports<AdaptiveEnd>& node) {
        node.about("ends an adaptive sampling: what adaptive-samples gives, of what was rendered")
            .in<Samples>("state", "of the last adaptive-step")
            .out<Samples>("samples", "as of adaptive-samples, weight among them")
            .out<LeafTree>("leaves", "the boxes that the domain was cut into");
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const AdaptiveSteps steps(in.get<Samples>("state"));
        if (steps.run().samples() == 0)
            ctx.fail(
                "nothing was sampled yet; render the requests of adaptive-begin and take them "
                "with adaptive-step");
        steps.run().hand_out(out);
    }
};

WEFT_NODE(AdaptiveBegin, "adaptive-begin", 4)
WEFT_NODE(AdaptiveStep, "adaptive-step", 4)
WEFT_NODE(AdaptiveEnd, "adaptive-end", 4)

}  // namespace
}  // namespace weft
