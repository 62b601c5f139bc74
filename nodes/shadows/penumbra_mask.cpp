// penumbra-mask: the pixels that see a light in part, for `where` of compare: there alone methods
// for soft shadows differ.
#include <fmt/format.h>

#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct PenumbraMask {
    float least = 0.01f;

    static void declare(Ports<PenumbraMask>& node) {
        node.about("1 in pixels that see a light in part, 0 in those that see all or none of it")
            .in<Image>("visibility", "Y: share of the light that is seen, of many rays a pixel")
            .out<Image>("mask", "Y: 1 or 0")
            .param("least", &PenumbraMask::least,
                   {.min = 0,
                    .max = 0.5,
                    .about = "of the light that must be seen, and as much that must be hidden"});
    }
    Cost cost(const Shapes& in) const { return cost_like(in, "visibility", "mask"); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& visibility = in.get<Image>("visibility");
        if (visibility.channels() != 1)
            ctx.fail(
                fmt::format("'visibility' has {} channels; expected one, as occluder-bounds "
                            "gives it",
                            visibility.channels()));
        Image mask = visibility;
        for (float& value : mask.pixels()) value = value > least && value < 1 - least ? 1.0f : 0.0f;
        out.set("mask", std::move(mask));
    }
};

WEFT_NODE(PenumbraMask, "penumbra-mask", 1)

}  // namespace
}  // namespace weft
