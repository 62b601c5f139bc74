// show-leaves: a slice through the boxes of adaptive sampling, each as bright as its mean, with its
// sides drawn.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "adaptive/adaptive_tree.h"
#include "adaptive/leaf_tree.h"
#include "image/image.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct ShowLeaves {
    std::string across = "x", down = "y";
    float at = 0.5f, zoom = 4;

    static void declare(Ports<ShowLeaves>& node) {
        node.about("a slice through the boxes of adaptive sampling, over any two axes")
            .in<LeafTree>("leaves", "boxes")
            .out<Image>("image", "R G B: means of boxes, darker along their sides")
            .param("across", &ShowLeaves::across, {.about = "axis from left to right"})
            .param("down", &ShowLeaves::down, {.about = "axis from top to bottom"})
            .param("at", &ShowLeaves::at,
                   {.min = 0, .max = 1, .about = "place of the slice on all other axes"})
            .param("zoom", &ShowLeaves::zoom,
                   {.unit = "px", .min = 0.1, .max = 64, .about = "of the slice to one of space"});
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const LeafTree& leaves = in.get<LeafTree>("leaves");
        const size_t axes = leaves.dimensions(), i = axis_of(leaves, across, ctx),
                     j = axis_of(leaves, down, ctx);
        if (i == j)
            ctx.fail(fmt::format("'across' and 'down' are both {}; a slice needs two", across));
        Image image(std::max(1, int(std::lround(leaves.extent[i] * zoom))),
                    std::max(1, int(std::lround(leaves.extent[j] * zoom))), 3);
        image.color_space = "lin_rec709";
        for (size_t l = 0; l < leaves.size(); ++l) {
            const float *lo = &leaves.lo[l * axes], *hi = &leaves.hi[l * axes];
            bool cut = true;
            for (size_t d = 0; d < axes; ++d) {
                const float place = std::min(at, 0x1.fffffep-1f) * leaves.extent[d];
                cut = cut && (d == i || d == j || (lo[d] <= place && place < hi[d]));
            }
            if (!cut) continue;
            // Pixels whose centres are inside.
            const auto first = [&](float side) { return int(std::ceil(side * zoom - 0.5f)); };
            const int x0 = first(lo[i]), x1 = std::min(first(hi[i]), image.width()),
                      y0 = first(lo[j]), y1 = std::min(first(hi[j]), image.height());
            for (int y = y0; y < y1; ++y)
                for (int x = x0; x < x1; ++x)
                    for (size_t c = 0; c < 3; ++c)
                        image.at(x, y)[c] =
                            leaves.mean[3 * l + c] * (x == x0 || y == y0 ? 0.4f : 1.0f);
        }
        out.set("image", std::move(image));
    }

  private:
    static size_t axis_of(const LeafTree& leaves, const std::string& name, Context& ctx) {
        const auto found = std::find(leaves.axes.begin(), leaves.axes.end(), name);
        if (found == leaves.axes.end())
            ctx.fail(fmt::format("no axis '{}'; there are {}", name, fmt::join(leaves.axes, ", ")));
        return size_t(found - leaves.axes.begin());
    }
};

WEFT_NODE(ShowLeaves, "show-leaves", 1)

}  // namespace
}  // namespace weft
