// preserve-energy: a reconstructed picture with the energy of the samples it was made from. A
// reconstruction that normalises its weights at every point gives some samples more than their
// share of the picture and others less: small highlights swell or shrink. Means of the samples
// themselves are noisy pixel by pixel but exact in total, so
//     picture *= mean of samples / mean of picture        under a Gaussian, each channel by itself,
// from a Gaussian just wide enough to average `samples` of them to one so wide that what a
// highlight lost at its rim is still within it. The wide ones hold totals, the narrow ones put
// right where it lies. Source: none known; the loss is measured in
// tests/light-field/discs_test.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "filters/gaussian_filter_kernel.h"
#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/isa.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct PreserveEnergy {
    float samples = 800, widest = 16;

    static void declare(Ports<PreserveEnergy>& node) {
        node.about("gives a picture the energy of its samples, from small areas to large ones")
            .in<Image>("image", "R G B; further channels stay as they are")
            .in<Image>("means",
                       "R G B of each pixel's samples and their number, of sample-means; same size")
            .out<Image>("image",
                        "the same with R G B scaled by what changes slowly over the picture")
            .param("samples", &PreserveEnergy::samples,
                   {.min = 1,
                    .max = 1e6,
                    .about = "that the narrowest Gaussian averages: more trusts the picture more, "
                             "less the samples"})
            .param(
                "widest", &PreserveEnergy::widest,
                {.unit = "px", .min = 0.5, .max = 64, .about = "deviation of the widest Gaussian"});
    }
    Cost cost(const Shapes& in) const {
        Cost c = cost_like(in, "image", "image");
        c.scratch_bytes = 2 * planes * 4 * double(in["image"].width) * double(in["image"].height);
        return c;
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image &image = in.get<Image>("image"), &means = in.get<Image>("means");
        if (image.channels() < 3 || means.channels() < 4 || image.width() != means.width() ||
            image.height() != means.height())
            ctx.fail(
                fmt::format("a picture of {} x {} with {} channels and means of {} x {} with {}; "
                            "expected one size, R G B, and R G B samples of sample-means",
                            image.width(), image.height(), image.channels(), means.width(),
                            means.height(), means.channels()));
        Image result = image;
        const Total total = total_of(means);
        if (total.pixels > 0)
            for (const float sigma : deviations(total.samples / total.pixels))
                scale(sigma, float(soft * total.light / total.pixels), means, result, ctx);
        out.set("image", std::move(result));
    }

  private:
    static constexpr int planes = 7;         // r g b of samples, r g b of the picture, known
    static constexpr float most_change = 8;  // times, up or down
    static constexpr double soft =
        0.02;  // of the mean light, added to both sides: what is black stays so

    struct Total {
        double pixels = 0, samples = 0, light = 0;
    };
    static Total total_of(const Image& means) {
        Total total;
        for (int y = 0; y < means.height(); ++y)
            for (int x = 0; x < means.width(); ++x) {
                const float* m = means.at(x, y);
                if (!(m[3] > 0)) continue;
                ++total.pixels;
                total.samples += double(m[3]);
                total.light +=
                    double(std::max(m[0], 0.0f) + std::max(m[1], 0.0f) + std::max(m[2], 0.0f)) / 3;
            }
        return total;
    }
    // A Gaussian's sum of weights squared, over its sum of squared weights, is 4 pi sigma^2 pixels.
    std::vector<float> deviations(double spp) const {
        std::vector<float> all;
        const float narrowest =
            std::max(float(std::sqrt(double(samples) / (4 * std::numbers::pi * spp))), 0.5f);
        for (float sigma = narrowest; sigma < 0.99f * widest; sigma *= 2) all.push_back(sigma);
        all.push_back(widest);
        return all;
    }

    static void scale(float sigma, float soft_light, const Image& means, Image& image,
                      Context& ctx) {
        const std::vector<float> taps = kernel::gaussian_taps(sigma);
        const int width = image.width(), height = image.height();
        kernel::Planes of_both(width, height, planes, int(taps.size() / 2)),
            wide(width, height, planes, 0);
        ctx.parallel_rows(height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < width; ++x) {
                    if (!(means.at(x, y)[3] > 0)) continue;
                    for (int c = 0; c < 3; ++c) {
                        of_both.row(c, y)[x] = means.at(x, y)[c];
                        of_both.row(3 + c, y)[x] = image.at(x, y)[c];
                    }
                    of_both.row(6, y)[x] = 1;
                }
        });
        const auto rows_of = [] {
            using namespace kernel;
            return WEFT_PICK(gaussian_rows);
        }();
        ctx.parallel_rows(height, [&](Rows rows) {
            rows_of(of_both, planes - 1, taps, rows.begin, rows.end, wide);
        });
        ctx.parallel_rows(height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < width; ++x)
                    for (int c = 0; c < 3; ++c) {
                        const float should = wide.row(c, y)[x] + soft_light,
                                    is = wide.row(3 + c, y)[x] + soft_light;
                        if (is > 0)
                            image.at(x, y)[c] *=
                                std::clamp(should / is, 1 / most_change, most_change);
                    }
        });
    }
};

WEFT_NODE(PreserveEnergy, "preserve-energy", 1)

}  // namespace
}  // namespace weft
