// show-slopes: the bounds of slopes as a picture. What all moves alike, or is as much out of focus,
// is yellow, the brighter the faster; what differs turns red; what stands still, or is in focus, is
// black; pixels of too few paths are blue.
#include <algorithm>

#include "adaptive/slopes.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

struct ShowSlopes {
    enum class Effect { motion, lens };
    Effect effect = Effect::motion;
    float full = 16;

    static void declare(Ports<ShowSlopes>& node) {
        node.about("bounds of slopes as a picture")
            .in<Image>("slopes", "of slope-bounds")
            .out<Image>("image", "R: the greatest slope, G: the least; B: bounds are not known")
            .choice("effect", &ShowSlopes::effect, {"motion", "lens"}, {.about = "which slopes"})
            .param("full", &ShowSlopes::full,
                   {.unit = "px", .min = 0.01, .max = 1e4, .about = "that is full brightness"});
    }
    Cost cost(const Shapes& in) const { return cost_like(in, "slopes", "image", 3); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& slopes = in.get<Image>("slopes");
        const SlopeReader read(slopes, "show-slopes");
        const bool motion = effect == Effect::motion;
        if (motion ? !read.motion() : !read.lens())
            ctx.fail(motion ? "the slopes hold no motion; set effect of slope-bounds to both"
                            : "the slopes hold no lens; set effect of slope-bounds to both");
        Image image(slopes.width(), slopes.height(), 3);
        image.color_space = "lin_rec709";
        ctx.parallel_rows(image.height(), [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < image.width(); ++x) {
                    const PixelSlopes s = read(x, y);
                    float* to = image.at(x, y);
                    const double lo = motion ? s.lo : s.lens_lo, hi = motion ? s.hi : s.lens_hi;
                    to[0] = float(std::max(std::abs(lo), std::abs(hi)) / double(full));
                    to[1] = float((motion ? s.least() : s.lens_least()) / double(full));
                    to[2] = s.known ? 0.0f : 0.5f;
                }
        });
        out.set("image", std::move(image));
    }
};

WEFT_NODE(ShowSlopes, "show-slopes", 1)

}  // namespace
}  // namespace weft
