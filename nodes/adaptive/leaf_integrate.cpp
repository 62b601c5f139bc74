// leaf-integrate: a picture of boxes. Source: Meister and Hachisuka 2022, whose boxes are as bright
// as the mean of their samples all over (order constant).  Departure: by default radiance within a
// box is what samples in and around it say by their own distances, at points of the box; as in
// Hachisuka et al. 2008, who cut boxes into cells and took the nearest sample of each. So it
// matters less where in their box samples fell, and what passes through a box is not smeared over
// it.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "adaptive/anisotropic_radiance.h"
#include "adaptive/leaf_tree.h"
#include "adaptive/structure_tensors_kernel.h"
#include "image/image.h"
#include "runtime/node.h"
#include "samples/lens_shape.h"
#include "samples/samples.h"

namespace weft {
namespace {

using namespace adaptive;

enum class Order { constant, linear };

// Of a pixel, with one axis beside x and y; over more they spread as their number's root.
constexpr double points_of_pixel = 64;

struct LeafIntegrate {
    Order order = Order::linear;

    static void declare(Ports<LeafIntegrate>& node) {
        node.about(
                "a picture of the boxes of adaptive sampling: a pixel is the mean of those above "
                "it, by the volume that they share")
            .in<Samples>("samples", "of adaptive-samples")
            .in<LeafTree>("leaves", "its boxes")
            .in<Metrics>("tensors", "of structure-tensors; of order linear, else found here",
                         Need::optional)
            .out<Image>("image", "R G B")
            .choice("order", &LeafIntegrate::order, {"constant", "linear"},
                    {.about = "whether radiance changes within a box, as the samples in and around "
                              "it say"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"image", {s.width, s.height, 3, 0, 12.0 * double(s.width) * double(s.height)}}},
                0,
                0};
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const LeafTree& leaves = in.get<LeafTree>("leaves");
        const Samples& samples = in.get<Samples>("samples");
        const size_t axes = leaves.dimensions();
        Image image(leaves.width, leaves.height, 3);
        image.color_space = samples.color_space;
        Metrics own;
        const Metrics* metrics = nullptr;
        if (order == Order::linear) {
            samples.require("leaf-integrate", {"rgb"});
            metrics = in.find<Metrics>("tensors");
            if (!metrics) own = metrics_of(samples, leaves, ctx), metrics = &own;
            if (metrics->size() != samples.size() || metrics->space.axes != leaves.axes)
                ctx.fail(
                    "'tensors' are of other samples or axes; link 'samples' and 'leaves' to both");
        }
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
                add_band(leaves, samples, metrics, of_band[b], int(b) * band,
                         std::min(int(b + 1) * band, leaves.height), image);
        });
        out.set("image", std::move(image));
    }

  private:
    static Metrics metrics_of(const Samples& samples, const LeafTree& leaves, Context& ctx) {
        Metrics metrics = metrics_over(samples, &leaves, "leaf-integrate");
        TensorSettings settings;
        settings.smooth = has_hidden_noise(samples);
        metrics.vary(samples.rgb(), settings, ctx);
        return metrics;
    }
    // What of a box lies over the pixels of some rows.
    struct Piece {
        size_t pixel;
        float x0, y0, x1, y1;
    };
    static void add_band(const LeafTree& leaves, const Samples& samples, const Metrics* metrics,
                         const std::vector<std::uint32_t>& which, int y0, int y1, Image& image) {
        const size_t axes = leaves.dimensions(), width = size_t(leaves.width);
        std::vector<double> sums(4 * width * size_t(y1 - y0));  // r g b volume
        std::vector<Piece> pieces;
        std::vector<float> rgb;
        PointsOfBox points(leaves, samples);
        std::optional<AnisotropicRadiance> radiance;
        if (metrics) radiance.emplace(*metrics, samples.rgb().data(), 1, Blend::linear);
        AnisotropicRadiance::Scratch scratch;
        for (const std::uint32_t l : which) {
            const float *lo = &leaves.lo[l * axes], *hi = &leaves.hi[l * axes];
            double above = 1;
            for (size_t d = 2; d < axes; ++d) above *= double(hi[d]) - double(lo[d]);
            pieces.clear();
            for (int y = std::max(y0, int(lo[1])); y < y1 && float(y) < hi[1]; ++y)
                for (int x = int(lo[0]); x < leaves.width && float(x) < hi[0]; ++x)
                    pieces.push_back({size_t(y - y0) * width + size_t(x), std::max(lo[0], float(x)),
                                      std::max(lo[1], float(y)), std::min(hi[0], float(x + 1)),
                                      std::min(hi[1], float(y + 1))});
            rgb.assign(3 * pieces.size(), 0.0f);
            if (!radiance)
                for (size_t i = 0; i < pieces.size(); ++i)
                    std::copy_n(&leaves.mean[3 * l], 3, &rgb[3 * i]);
            else
                points.mean(l, pieces, *radiance, scratch, rgb);
            for (size_t i = 0; i < pieces.size(); ++i) {
                const Piece& p = pieces[i];
                const double share =
                    above * (double(p.x1) - double(p.x0)) * (double(p.y1) - double(p.y0));
                double* to = &sums[4 * p.pixel];
                for (size_t c = 0; c < 3; ++c) to[c] += share * double(rgb[3 * i + c]);
                to[3] += share;
            }
        }
        for (int y = y0; y < y1; ++y)
            for (size_t x = 0; x < width; ++x) {
                const double* from = &sums[4 * (size_t(y - y0) * width + x)];
                for (size_t c = 0; c < 3; ++c)
                    image.at(int(x), y)[c] = from[3] > 0 ? float(from[c] / from[3]) : 0.0f;
            }
    }

    // Points of a box over each of its pieces: so many as its part of all the other axes is of
    // `points_of_pixel`, 16 at most, by multiples of powers of the root of x^(D + 1) = x + 1
    // (Roberts 2018).
    class PointsOfBox {
      public:
        PointsOfBox(const LeafTree& leaves, const Samples& samples)
            : leaves_(leaves),
              shape_(samples.lens.value_or(Lens{})),
              shutter_(shutter_of(samples.meta)) {
            double root = 2;
            for (int i = 0; i < 64; ++i)
                root = std::pow(1 + root, 1.0 / double(leaves.dimensions() + 1));
            double power = 1;
            for (size_t d = 0; d < leaves.dimensions(); ++d) steps_[d] = power /= root;
            for (size_t d = 0; d < leaves.dimensions(); ++d) {
                if (leaves.axes[d] == "u") u_ = d;
                if (leaves.axes[d] == "v") v_ = d;
                if (leaves.axes[d] == "t") t_ = d;
            }
        }
        // Mean radiance over each piece of box `l`.
        void mean(size_t l, const std::vector<Piece>& pieces, const AnisotropicRadiance& radiance,
                  AnisotropicRadiance::Scratch& scratch, std::vector<float>& rgb) {
            const size_t axes = leaves_.dimensions();
            const float *lo = &leaves_.lo[l * axes], *hi = &leaves_.hi[l * axes];
            double wanted = points_of_pixel * std::sqrt(double(std::max<size_t>(axes, 3) - 2));
            for (size_t d = 2; d < axes; ++d)
                wanted *= double(hi[d] - lo[d]) / double(leaves_.extent[d]);
            const auto n = size_t(std::clamp(std::ceil(wanted), 1.0, 16.0));
            places_.start(axes, n * pieces.size());
            for (size_t k = 0; k < n; ++k) {
                std::array<float, most_axes> place{};
                const auto number = [&](size_t d) {
                    const double turned = 0.5 + steps_[d] * double(k + 1);
                    return float(turned - std::floor(turned));
                };
                // The last axis in equal steps.
                for (size_t d = 2; d < axes; ++d) {
                    const float along = d + 1 == axes ? (float(k) + 0.5f) / float(n) : number(d);
                    place[d] = lo[d] + (hi[d] - lo[d]) * along;
                }
                to_samples(place.data());
                const float x = number(0), y = number(1);
                for (size_t i = 0; i < pieces.size(); ++i) {
                    const Piece& piece = pieces[i];
                    place[0] = piece.x0 + (piece.x1 - piece.x0) * x;
                    place[1] = piece.y0 + (piece.y1 - piece.y0) * y;
                    for (size_t d = 0; d < axes; ++d) places_.at[d][n * i + k] = place[d];
                }
            }
            found_.resize(3 * places_.size);
            std::array<float, most_axes> from{}, to{};
            places_.bounds(from.data(), to.data());
            radiance.prepare(from.data(), to.data(), scratch);
            radiance.at(places_, scratch, [&](size_t i) { return &found_[3 * i]; });
            // Differences to the first: what is the same everywhere stays so to the bit.
            for (size_t i = 0; i < pieces.size(); ++i)
                for (size_t c = 0; c < 3; ++c) {
                    const float* of = &found_[3 * n * i + c];
                    float more = 0;
                    for (size_t k = 1; k < n; ++k) more += (of[3 * k] - of[0]) / float(n);
                    rgb[3 * i + c] = of[0] + more;
                }
        }

      private:
        // Boxes lie in the square of the lens and in the shutter's numbers, samples on the lens and
        // in time.
        void to_samples(float* place) const {
            const std::vector<float>& extent = leaves_.extent;
            if (u_ > 0 && v_ > 0) {
                const auto on = on_lens(place[u_] / extent[u_], place[v_] / extent[v_], shape_);
                place[u_] = 0.5f * (on[0] + 1) * extent[u_];
                place[v_] = 0.5f * (on[1] + 1) * extent[v_];
            }
            if (t_ > 0) place[t_] = shutter_.time(place[t_] / extent[t_]) * extent[t_];
        }

        const LeafTree& leaves_;
        Lens shape_;
        ShutterCurve shutter_;
        std::array<double, most_axes> steps_{};
        size_t u_ = 0, v_ = 0, t_ = 0;  // axes; 0: there is none
        Places places_;
        std::vector<float> found_;
    };
};

WEFT_NODE(LeafIntegrate, "leaf-integrate", 7)

}  // namespace
}  // namespace weft
