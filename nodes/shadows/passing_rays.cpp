// passing-rays: where the rays of light samples went past surfaces that others met
// (passing_rays_kernel.h).
#include "shadows/passing_rays_kernel.h"

#include <algorithm>

#include "runtime/node.h"

namespace weft {
namespace {

struct PassRays {
    float radius_scale = 2;

    static void declare(Ports<PassRays>& node) {
        node.about(
                "finds where rays of light samples pass surfaces that others meet: what "
                "ray-vote-coverage knows the rims of surfaces by")
            .in<Hierarchy>("hits", "of what the light sees along one ray each")
            .in<LightView>("light-view", "of the same")
            .in<Samples>("samples", "the camera's: light_density scales the search, and what all_lit says is "
                         "clear is not looked at",
                         Need::optional)
            .out<Samples>("passes",
                          "a light sample where a ray passes a surface: at its depth, with its "
                          "motion; `end` is how deep the ray gets, `bulge` (px) half the radius of a "
                          "surface that bends there")
            .param("radius-scale", &PassRays::radius_scale,
                   {.unit = "R",
                    .min = 0.05,
                    .max = 32,
                    .about = "how near to a surface's samples a ray passes it"});
    }
    Cost cost(const Shapes& in) const {
        const double n = double(in["hits"].records);
        return {{{"passes", {0, 0, 0, std::int64_t(n), 20 * n}}}, 8 * n, 2000 * n};
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Hierarchy& hits = in.get<Hierarchy>("hits");
        std::span<const float> density, clear;
        if (const Samples* samples = in.find<Samples>("samples"))
            density = samples->values("light_density"), clear = samples->values("all_lit");
        const auto source = hits.source.view();
        const size_t known = std::max(density.size(), clear.size());
        if (known > 0 && source.size() != hits.size())
            throw Error(
                "'hits' do not say which camera samples they are for; link a hierarchy of light "
                "samples");
        if (known > 0 && !source.empty() &&
            *std::max_element(source.begin(), source.end()) >= known)
            throw Error(
                "'samples' are not those that 'hits' are for: link the ones that the light "
                "samples were made of");
        out.set("passes",
                shadows::passes(hits, density, clear, in.get<LightView>("light-view"), {radius_scale}, ctx));
    }
};

WEFT_NODE(PassRays, "passing-rays", 4)

}  // namespace
}  // namespace weft
