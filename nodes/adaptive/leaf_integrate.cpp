// leaf-integrate: a picture of boxes, each as bright as the mean of its samples all over.
// Source: Meister and Hachisuka 2022.
#include <algorithm>
#include <cmath>

#include "adaptive/leaf_tree.h"
#include "image/image.h"
#include "runtime/node.h"
#include "samples/samples.h"

namespace weft {
namespace {

struct LeafIntegrate {
    static void declare(Ports<LeafIntegrate>& node) {
        node.about(
                "a picture of the boxes of adaptive sampling: a pixel is the mean of those above "
                "it, by the volume that they share")
            .in<Samples>("samples", "of adaptive-samples")
            .in<LeafTree>("leaves", "its boxes")
            .out<Image>("image", "R G B");
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"image", {s.width, s.height, 3, 0, 12.0 * double(s.width) * double(s.height)}}},
                0,
                0};
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const LeafTree& leaves = in.get<LeafTree>("leaves");
        const size_t axes = leaves.dimensions();
        Image image(leaves.width, leaves.height, 3);
        image.color_space = in.get<Samples>("samples").color_space;
        // The leaves of each band of rows, in their order.
        constexpr int band = 16;
        std::vector<std::vector<std::uint32_t>> of_band(size_t((leaves.height + band - 1) / band));
        for (std::uint32_t l = 0; l < leaves.size(); ++l) {
            const size_t first = size_t(leaves.lo[l * axes + 1]) / band;
            for (size_t b = first; b < of_band.size() && float(b * band) < leaves.hi[l * axes + 1];
                 ++b)
                of_band[b].push_back(l);
        }
        ctx.parallel(of_band.size(), 1, [&](size_t begin, size_t end) {
            for (size_t b = begin; b < end; ++b)
                add_band(leaves, of_band[b], int(b) * band,
                         std::min(int(b + 1) * band, leaves.height), image);
        });
        out.set("image", std::move(image));
    }

  private:
    static void add_band(const LeafTree& leaves, const std::vector<std::uint32_t>& which, int y0,
                         int y1, Image& image) {
        const size_t axes = leaves.dimensions(), width = size_t(leaves.width);
        std::vector<double> sums(4 * width * size_t(y1 - y0));  // r g b volume
        for (const std::uint32_t l : which) {
            const float *lo = &leaves.lo[l * axes], *hi = &leaves.hi[l * axes];
            double above = 1;
            for (size_t d = 2; d < axes; ++d) above *= double(hi[d]) - double(lo[d]);
            for (int y = std::max(y0, int(lo[1])); y < y1 && float(y) < hi[1]; ++y) {
                const double in_y =
                    std::min(double(hi[1]), y + 1.0) - std::max(double(lo[1]), double(y));
                for (int x = int(lo[0]); x < leaves.width && float(x) < hi[0]; ++x) {
                    const double share =
                        above * in_y *
                        (std::min(double(hi[0]), x + 1.0) - std::max(double(lo[0]), double(x)));
                    double* to = &sums[4 * (size_t(y - y0) * width + size_t(x))];
                    for (size_t c = 0; c < 3; ++c) to[c] += share * double(leaves.mean[3 * l + c]);
                    to[3] += share;
                }
            }
        }
        for (int y = y0; y < y1; ++y)
            for (size_t x = 0; x < width; ++x) {
                const double* from = &sums[4 * (size_t(y - y0) * width + x)];
                for (size_t c = 0; c < 3; ++c)
                    image.at(int(x), y)[c] = from[3] > 0 ? float(from[c] / from[3]) : 0.0f;
            }
    }
};

WEFT_NODE(LeafIntegrate, "leaf-integrate", 1)

}  // namespace
}  // namespace weft
