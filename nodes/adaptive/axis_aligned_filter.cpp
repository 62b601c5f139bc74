// axis-aligned-filter: a picture under a filter as wide as each pixel's width says: the last step
// of axis-aligned filtering of shadows, motion and defocus, whose own nodes make the widths.
// Source: Mehta et al. 2012, Sec. 5; Egan et al. 2009.  Departure: what passes for the same surface
// is told by ratios and angles alone, so that scenes have no unit.
#include "adaptive/axis_aligned_filter_kernel.h"

#include <fmt/format.h>

#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct AxisAlignedFilter {
    kernel::SurfaceGuard guard;
    int reach = 64;
    float normal_angle = guard.normal_angle, depth = guard.depth, width_ratio = guard.width_ratio;

    static void declare(Ports<AxisAlignedFilter>& node) {
        node.about("blurs each pixel as far as its width says, within its surface")
            .in<Image>("image", "what to filter: visibility, or a picture; all channels")
            .in<Image>("width",
                       "beta: where weights end, in px, or between places x, y where it has "
                       "these (radius: the same in px); n.x, n.y: a direction to filter along. Of "
                       "axis-aligned-width or blur-width")
            .in<Image>("features",
                       "what tells surfaces apart, of these: id; normal.x ..; position.x ..; z",
                       Need::optional)
            .out<Image>("image", "same size and channels; pixels of width 0 as they were")
            .param("reach", &AxisAlignedFilter::reach,
                   {.unit = "px", .min = 0, .max = 1024, .about = "widest filter"})
            .param("normal-angle", &AxisAlignedFilter::normal_angle,
                   {.unit = "degrees",
                    .min = 0,
                    .max = 180,
                    .about = "normals farther apart are another surface"})
            .param("depth", &AxisAlignedFilter::depth,
                   {.min = 0,
                    .max = 1e6,
                    .about = "what lies farther off a pixel's plane, or depth, in parts of its "
                             "distance, is another surface"})
            .param("width-ratio", &AxisAlignedFilter::width_ratio,
                   {.min = 1, .max = 1e6, .about = "pixels of widths farther apart do not mix"});
    }
    Cost cost(const Shapes& in) const {
        return cost_like(in, "image", "image", 0, double(in["image"].channels), 100);
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image &image = in.get<Image>("image"), &width = in.get<Image>("width");
        const Image* features = in.find<Image>("features");
        for (const auto& [port, other] : {std::pair{"width", &width}, {"features", features}})
            if (other && (other->width() != image.width() || other->height() != image.height()))
                ctx.fail(fmt::format("'{}' is {} x {}, 'image' {} x {}; expected one size", port,
                                     other->width(), other->height(), image.width(),
                                     image.height()));
        const kernel::FilterWidths widths{
            &width,          width.find("beta"), width.find("radius"), width.find("x"),
            width.find("y"), width.find("n.x"),  width.find("n.y"),    reach};
        if (widths.beta < 0 || (widths.x >= 0) != (widths.y >= 0) ||
            (widths.x >= 0) != (widths.radius >= 0) || (widths.nx >= 0) != (widths.ny >= 0))
            ctx.fail(
                fmt::format("'width' has {}; expected beta, and either radius x y, or n.x n.y, or "
                            "no more: as axis-aligned-width and blur-width make it",
                            fmt::join(width.names(), " ")));
        const kernel::SurfaceGuard by{features, normal_angle, depth, width_ratio};
        out.set("image", widths.nx >= 0 ? kernel::filter_along(image, widths, by, ctx)
                                        : kernel::filter_all_round(image, widths, by, ctx));
    }
};

WEFT_NODE(AxisAlignedFilter, "axis-aligned-filter", 1)

}  // namespace
}  // namespace weft
