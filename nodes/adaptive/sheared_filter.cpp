// sheared-filter: motion blur and defocus by a filter sheared along what moves, or is out of focus
// (sheared_filter_kernel.h).
#include <atomic>

#include "adaptive/sheared_node.h"
#include "image/each_line.h"

namespace weft {
namespace {
using namespace adaptive;

struct ShearedFilterNode : ShearedNode {
    enum class Lens { closed, pieces };
    Lens lens = Lens::closed;

    static void declare(Ports<ShearedFilterNode>& node) {
        node.about(
                "means of the samples that the mean slope of each pixel carries into it, over lens "
                "and shutter")
            .in<Samples>("samples", "xy, z, rgb (t, motion; uv and a lens; weight)")
            .in<Image>("slopes", "of slope-bounds");
        declare_shared(node);
        node.choice("lens", &ShearedFilterNode::lens, {"closed", "pieces"},
                    {.about = "a round lens's integral: in closed form, or over columns of it, as "
                              "factored-sheared has it; one with blades is always in pieces"});
    }
    Cost cost(const Shapes& in) const { return cost_for(in, 0, 2000); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const Image& slopes = in.get<Image>("slopes");
        check(samples, slopes, "sheared-filter", ctx);
        const ShearedFilter filter(samples, &slopes, settings(lens == Lens::pieces));
        const SlopeReader held(slopes, "sheared-filter");
        if (!(held.motion() && samples.has_motion()) && !(held.lens() && samples.has_lens()))
            ctx.warn(
                "neither motion nor a lens is in both samples and slopes; the picture is the box "
                "filter's");
        ShearedPictures pictures(samples);
        std::atomic<size_t> empty = 0;
        each_line(ctx, samples.height, "rows", [&](int y) {
            for (int x = 0; x < samples.width; ++x) {
                const ShearedFilter::Pixel pixel = filter.filtered(x, y);
                pictures.set(x, y, pixel);
                empty += !(pixel.effective > 0);
            }
        });
        warn_of_empty(empty, samples, ctx);
        pictures.give(out);
    }
};

WEFT_NODE(ShearedFilterNode, "sheared-filter", 4)

}  // namespace
}  // namespace weft
