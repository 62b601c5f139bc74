// separate-light: takes one light's direct light out of a sample buffer, so that its shadow can be
// reconstructed apart: what is left, and what it would bring if nothing stood before it.
#include <fmt/format.h>

#include "runtime/node.h"
#include "samples/file_bytes.h"
#include "shadows/light_view.h"

namespace weft {
namespace {

struct SeparateLight {
    static void declare(Ports<SeparateLight>& node) {
        node.about("splits samples into what a light brings unshadowed and all the rest")
            .in<Samples>("samples",
                         "rgb, direct, direct_unshadowed; light_index where the scene has other "
                         "lights or a sky")
            .in<LightView>("light-view", "which light")
            .out<Samples>(
                "rest",
                "rgb without this light's direct light; further lights can be taken out of it")
            .out<Samples>("direct", "rgb is what the light brings with nothing in its way");
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        samples.require("separate-light", {"rgb", "direct", "direct_unshadowed"});
        const Channel* index = samples.find("light_index");
        const auto rgb = samples.rgb(), direct = samples.values("direct"),
                   open = samples.values("direct_unshadowed");
        const Json* lights = samples.meta.find("lights");
        if (!index && lights && lights->items.size() > 1)
            ctx.fail(
                fmt::format("the samples' {} lights cannot be told apart without light_index; "
                            "render-samples writes it on demand (channels)",
                            lights->items.size()));
        std::vector<float> rest(3 * samples.size()), own(3 * samples.size());
        ctx.parallel(samples.size(), 65536, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                const bool ours = !index || index->ids[i] == view.light;
                for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
                    rest[c] = ours ? rgb[c] - direct[c] : rgb[c];
                    own[c] = ours ? open[c] : 0.0f;
                }
            }
        });
        // Nobody else asks for them, as a rule.
        forget_pages(direct), forget_pages(open);
        Samples left = samples, alone = samples;
        left.add("rgb", 3, std::move(rest));
        alone.add("rgb", 3, std::move(own));
        out.set("rest", std::move(left));
        out.set("direct", std::move(alone));
    }
};

WEFT_NODE(SeparateLight, "separate-light", 1)

}  // namespace
}  // namespace weft
