// fit-light-view: a light as a camera that sees all receivers (light_view.h): its film has about as
// many pixels a receiver as the camera's, and holds all of them from any point of the light.
#include "runtime/node.h"
#include "shadows/fit_light_view_kernel.h"

namespace weft {
namespace {

struct FitLightView {
    std::string light;
    float focus = 0, pixels = 0;

    static void declare(Ports<FitLightView>& node) {
        node.about(
                "a light that looks at the samples' first hits: its area the lens, a plane before "
                "it the film")
            .in<Samples>("samples", "xy, z (uv, t, motion); meta.lights and meta.camera")
            .out<LightView>("light-view", "holds all receivers, seen from any point of the light")
            .param(
                "light", &FitLightView::light,
                {.about =
                     "its name in meta.lights, or its place there, from 0; empty: the first with an "
                     "area, or else the first. A mesh that shines is called as its instance"})
            .param("focus", &FitLightView::focus,
                   {.unit = "scene",
                    .min = 0,
                    .max = 1e15,
                    .about = "distance at which samples of all points of the light meet; 0: "
                             "between the nearest and the farthest receiver"})
            .param("pixels", &FitLightView::pixels,
                   {.unit = "px",
                    .min = 0,
                    .max = 1e7,
                    .about = "of film that a unit of length is wide at distance 1; 0: about as "
                             "dense as the camera's"});
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        out.set("light-view", shadows::fit_light_view(in.get<Samples>("samples"),
                                                      {light, double(pixels), double(focus)}, ctx));
    }
};

WEFT_NODE(FitLightView, "fit-light-view", 2)

}  // namespace
}  // namespace weft
