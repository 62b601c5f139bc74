// leaf-integrate: a picture of boxes. Source: Meister and Hachisuka 2022, whose boxes are as bright
// as the mean of their samples all over (order constant).  Departure: by default radiance changes
// linearly within a box, through that mean at its samples' mean place, as gradients of the samples
// around say; so it matters less where in their box samples fell. The lens' axes are left out:
// there boxes lie in the square, samples in the disk.
#include <algorithm>
#include <array>
#include <cmath>

#include "adaptive/leaf_tree.h"
#include "adaptive/metrics.h"
#include "adaptive/structure_tensors_kernel.h"
#include "image/image.h"
#include "runtime/node.h"
#include "samples/samples.h"

namespace weft {
namespace {

using namespace adaptive;

enum class Order { constant, linear };

// Of each box, three channels: how radiance changes, and between what it stays.
struct BoxSlopes {
    std::vector<float> gradient;     // 3 x axes a box, per px
    std::vector<float> place;        // axes a box, px: of its samples, in the mean
    std::vector<float> least, most;  // 3 a box
};

struct LeafIntegrate {
    Order order = Order::linear;

    static void declare(Ports<LeafIntegrate>& node) {
        node.about(
                "a picture of the boxes of adaptive sampling: a pixel is the mean of those above "
                "it, by the volume that they share")
            .in<Samples>("samples", "of adaptive-samples")
            .in<LeafTree>("leaves", "its boxes")
            .out<Image>("image", "R G B")
            .choice("order", &LeafIntegrate::order, {"constant", "linear"},
                    {.about = "whether radiance changes within a box"});
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
        const BoxSlopes slopes = order == Order::linear
                                     ? slopes_of(in.get<Samples>("samples"), leaves, ctx)
                                     : BoxSlopes{};
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
                add_band(leaves, slopes, of_band[b], int(b) * band,
                         std::min(int(b + 1) * band, leaves.height), image);
        });
        out.set("image", std::move(image));
    }

  private:
    static float value(const LeafTree& leaves, const BoxSlopes& slopes, size_t l, size_t c,
                       const float* middle) {
        const size_t axes = leaves.dimensions();
        const float mean = leaves.mean[3 * l + c];
        if (slopes.gradient.empty() || leaves.first[l + 1] == leaves.first[l]) return mean;
        float change = 0;
        for (size_t d = 0; d < axes; ++d)
            change +=
                slopes.gradient[(3 * l + c) * axes + d] * (middle[d] - slopes.place[l * axes + d]);
        return std::clamp(mean + change, slopes.least[3 * l + c], slopes.most[3 * l + c]);
    }
    // Gradients of a box' samples, and of what is around them, in the mean. Radiance goes beyond
    // what its samples have by as much as these differ.
    static BoxSlopes slopes_of(const Samples& samples, const LeafTree& leaves, Context& ctx) {
        samples.require("leaf-integrate", {"rgb"});
        const Metrics metrics = metrics_over(samples, &leaves, "leaf-integrate");
        const PointTree& tree = *metrics.tree;
        const size_t axes = leaves.dimensions();
        std::vector<float> rgb;
        std::vector<std::uint32_t> place(samples.size());
        for (std::uint32_t k = 0; k < tree.size(); ++k) {
            const size_t i = tree.order()[k];
            place[i] = k;
            rgb.insert(rgb.end(), &samples.rgb()[3 * i], &samples.rgb()[3 * i] + 3);
        }
        const std::vector<float> all = gradients(tree, rgb, TensorSettings{}, ctx);
        BoxSlopes slopes;
        slopes.gradient.resize(3 * axes * leaves.size());
        slopes.place.resize(axes * leaves.size());
        for (size_t l = 0; l < leaves.size(); ++l) {
            const float share = 1 / float(std::max(1u, leaves.first[l + 1] - leaves.first[l]));
            float least[3] = {3e38f, 3e38f, 3e38f}, most[3] = {-3e38f, -3e38f, -3e38f};
            for (std::uint32_t k = leaves.first[l]; k < leaves.first[l + 1]; ++k) {
                const size_t at = place[leaves.samples[k]];
                for (size_t d = 0; d < axes; ++d) {
                    slopes.place[l * axes + d] += share * tree.at(d)[at];
                    const bool lens = leaves.axes[d] == "u" || leaves.axes[d] == "v";
                    for (size_t c = 0; c < 3 && !lens; ++c)
                        slopes.gradient[(3 * l + c) * axes + d] +=
                            share * all[(3 * at + c) * axes + d];
                }
                for (size_t c = 0; c < 3; ++c) {
                    least[c] = std::min(least[c], rgb[3 * at + c]);
                    most[c] = std::max(most[c], rgb[3 * at + c]);
                }
            }
            for (size_t c = 0; c < 3; ++c) {
                slopes.least.push_back(least[c] - (most[c] - least[c]));
                slopes.most.push_back(most[c] + (most[c] - least[c]));
            }
        }
        return slopes;
    }
    static void add_band(const LeafTree& leaves, const BoxSlopes& slopes,
                         const std::vector<std::uint32_t>& which, int y0, int y1, Image& image) {
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
                    // The middle of what box and pixel share.
                    std::array<float, most_axes> middle{};
                    for (size_t d = 0; d < axes; ++d) {
                        const float pixel = d == 0 ? float(x) : float(y);
                        middle[d] =
                            d < 2 ? 0.5f * (std::max(lo[d], pixel) + std::min(hi[d], pixel + 1))
                                  : 0.5f * (lo[d] + hi[d]);
                    }
                    for (size_t c = 0; c < 3; ++c)
                        to[c] += share * double(value(leaves, slopes, l, c, middle.data()));
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

WEFT_NODE(LeafIntegrate, "leaf-integrate", 2)

}  // namespace
}  // namespace weft
