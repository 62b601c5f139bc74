// passing-rays: where the rays of light samples went past surfaces that others met
// (passing_rays_kernel.h).
#include "shadows/passing_rays_kernel.h"

#include "runtime/node.h"

namespace weft {
namespace {

struct PassRays {
    float radius_scale = 2;

    static void declare(Ports<PassRays>& node) {
        node.about(
                "adds to light samples where their rays pass surfaces that others meet: what "
                "ray-vote-coverage knows the rims of surfaces by")
            .in<Samples>("light-samples", "what the light sees along one ray each")
            .in<Hierarchy>("hierarchy", "of the same")
            .in<LightView>("light-view", "of the same")
            .in<Samples>("samples", "the camera's, whose light_density scales the search",
                         Need::optional)
            .out<Samples>(
                "light-samples",
                "the same with `end` 0, and a sample where a ray passes a surface: at its "
                "depth, with its motion; `end` is how deep the ray gets")
            .param("radius-scale", &PassRays::radius_scale,
                   {.unit = "R",
                    .min = 0.05,
                    .max = 32,
                    .about = "how near to a surface's samples a ray passes it"});
    }
    Cost cost(const Shapes& in) const {
        const double n = double(in["light-samples"].records);
        return {{{"light-samples", {0, 0, 0, std::int64_t(n), 56 * n}}}, 0, 2000 * n};
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& lights = in.get<Samples>("light-samples");
        const Hierarchy& hierarchy = in.get<Hierarchy>("hierarchy");
        lights.require("passing-rays", {"xy", "z", "source"});
        if (hierarchy.size() != lights.size())
            throw Error("'hierarchy' is not that of 'light-samples': link the one made of them");
        std::span<const float> density;
        if (const Samples* samples = in.find<Samples>("samples"))
            density = samples->values("light_density");
        out.set("light-samples",
                shadows::with_passes(lights, hierarchy, density, in.get<LightView>("light-view"),
                                     {radius_scale}, ctx));
    }
};

WEFT_NODE(PassRays, "passing-rays", 2)

}  // namespace
}  // namespace weft
