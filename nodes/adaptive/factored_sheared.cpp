// factored-sheared: defocus by the sheared filter, in two passes (factored_sheared_kernel.h): what
// sheared-filter makes, in a fraction of its time where circles of confusion are large.
#include "adaptive/factored_sheared_kernel.h"

#include "adaptive/sheared_node.h"
#include "image/each_line.h"

namespace weft {
namespace {
using namespace adaptive;

struct FactoredShearedNode : ShearedNode {
    enum class Order { grid, any };
    Order order = Order::grid;
    int rows = 8;

    static void declare(Ports<FactoredShearedNode>& node) {
        node.about("the sheared filter of a lens, over x and u first, then over y and v")
            .in<Samples>("samples", "xy, z, rgb, uv and a lens (weight)")
            .in<Image>("slopes", "of slope-bounds, of the lens alone");
        declare_shared(node);
        node.choice("order", &FactoredShearedNode::order, {"grid", "any"},
                    {.about = "grid: l x l samples a pixel, sample j l + i in row j of v, and "
                              "nothing lost; any: samples are put in rows of the lens, and take "
                              "the mean y and v of each"})
            .param("rows", &FactoredShearedNode::rows,
                   {.min = 1, .max = 256, .about = "of the lens, where order is any"});
    }
    Cost cost(const Shapes& in) const { return cost_for(in, sizeof(LensCells::Sample) + 4, 400); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const Image& slopes = in.get<Image>("slopes");
        check(samples, slopes, "factored-sheared", ctx);
        samples.require("factored-sheared", {"uv"});
        const SlopeReader held(slopes, "factored-sheared");
        if (!held.lens() || !samples.has_lens())
            ctx.fail(held.lens() ? "the samples have no lens; motion takes sheared-filter"
                                 : "the slopes hold no lens; set effect of slope-bounds to lens");
        if (held.motion() && samples.has_motion())
            ctx.fail(
                "filters a lens alone, and the slopes hold motion; set effect of slope-bounds to "
                "lens, or use sheared-filter");
        double widest = 0;
        for (int y = 0; y < samples.height; ++y)
            for (int x = 0; x < samples.width; ++x)
                widest = std::max(widest, std::abs(held(x, y).coc()));
        const LensCells cells = order == Order::grid
                                    ? LensCells::of_grid(samples, float(widest), "factored-sheared")
                                    : LensCells::of_any(samples, rows);
        const FactoredSheared filter(samples, slopes, settings(true), cells);
        ShearedPictures pictures(samples);
        std::atomic<size_t> empty = 0;
        each_line(ctx, samples.width, "columns", [&](int x) {
            std::vector<SeenCell> seen;
            std::vector<ShearedFilter::Pixel> pixels(size_t(samples.height));
            filter.column(x, seen, pixels);
            for (int y = 0; y < samples.height; ++y) {
                pictures.set(x, y, pixels[size_t(y)]);
                empty += !(pixels[size_t(y)].effective > 0);
            }
        });
        warn_of_empty(empty, samples, ctx);
        pictures.give(out);
    }
};

WEFT_NODE(FactoredShearedNode, "factored-sheared", 2)

}  // namespace
}  // namespace weft
