// prefer-unbiased: a picture where it agrees with the samples' own means, another where it does not. Means of samples are
// noisy but right on average: a picture whose local mean departs from theirs by more than noise explains is wrong there,
// as a reconstruction is that carries a shadow along with the ground it moves over. Measured are, under a Gaussian,
//     t = (mean of picture - samples)^2 / variance of the mean of samples
// of both pictures; where the first's is larger by more than `low` the second begins to take over.
// Source: none; the test is that of a mean against a known one, in squared standard errors.
#include <fmt/format.h>

#include <numeric>

#include "filters/gaussian_filter_kernel.h"
#include "image/image.h"
#include "image/image_cost.h"
#include "image/smooth_step.h"
#include "runtime/isa.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct PreferUnbiased {
    float sigma = 3, low = 2, high = 6;

    static void declare(Ports<PreferUnbiased>& node) {
        node.about("a picture where it agrees with the samples' own means but for noise, another where it does not")
            .in<Image>("image", "the picture to take wherever it is not biased; R G B")
            .in<Image>("other", "what to take where it is; same size")
            .in<Image>("mean", "R G B, means of each pixel's samples, as pixel-features has them")
            .in<Image>("variance", "R G B, of these means")
            .out<Image>("image", "a smooth mixture of both")
            .param("sigma", &PreferUnbiased::sigma, {.unit = "px", .min = 0.3, .max = 64, .about = "deviation of the Gaussian that means are taken under"})
            .param("low", &PreferUnbiased::low, {.min = 0, .max = 1e6, .about = "excess of t, in squared standard errors, from which on the other begins to count"})
            .param("high", &PreferUnbiased::high, {.min = 0, .max = 1e6, .about = "excess from which on it alone does"});
    }
    Cost cost(const Shapes& in) const {
        Cost c = cost_like(in, "image", "image");
        c.scratch_bytes = 20 * 4 * double(in["image"].width) * double(in["image"].height);
        return c;
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image &image = in.get<Image>("image"), &other = in.get<Image>("other"), &mean = in.get<Image>("mean"), &variance = in.get<Image>("variance");
        for (const Image* i : {&image, &other, &mean, &variance})
            if (i->channels() < 3 || i->width() != image.width() || i->height() != image.height())
                ctx.fail(fmt::format("pictures of {} x {} with {} channels and {} x {} with {}; expected one size, and R G B in each", image.width(),
                                     image.height(), image.channels(), i->width(), i->height(), i->channels()));
        if (!(low < high)) ctx.fail(fmt::format("low is {}, high is {}; expected low below high", low, high));

        const std::vector<float> taps = kernel::gaussian_taps(sigma);
        std::vector<float> squares(taps);
        for (float& t : squares) t *= t;
        const int radius = int(taps.size() / 2), width = image.width(), height = image.height();
        kernel::Planes off(width, height, 7, radius), noise(width, height, 4, radius), off_means(width, height, 7, 0), noise_means(width, height, 4, 0);
        ctx.parallel_rows(height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < width; ++x) {
                    for (int c = 0; c < 3; ++c) {
                        off.row(c, y)[x] = image.at(x, y)[c] - mean.at(x, y)[c];
                        off.row(3 + c, y)[x] = other.at(x, y)[c] - mean.at(x, y)[c];
                        noise.row(c, y)[x] = variance.at(x, y)[c];
                    }
                    off.row(6, y)[x] = noise.row(3, y)[x] = 1;
                }
        });
        const auto rows_of = [] {
            using namespace kernel;
            return WEFT_PICK(gaussian_rows);
        }();
        ctx.parallel_rows(height, [&](Rows rows) {
            rows_of(off, 6, taps, rows.begin, rows.end, off_means);
            rows_of(noise, 3, squares, rows.begin, rows.end, noise_means);
        });
        // The variance of a weighted mean is the sum of squared weights times variances, weights adding up to 1.
        const float sum = std::accumulate(taps.begin(), taps.end(), 0.0f), square = std::accumulate(squares.begin(), squares.end(), 0.0f);
        const float of_mean = square * square / (sum * sum * sum * sum);
        Image result = image;
        ctx.parallel_rows(height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < width; ++x) {
                    float excess = 0;
                    for (int c = 0; c < 3; ++c) {
                        const float a = off_means.row(c, y)[x], b = off_means.row(3 + c, y)[x];
                        excess += (a * a - b * b) / (of_mean * noise_means.row(c, y)[x] + 1e-8f) / 3;
                    }
                    const float s = smooth_step(low, high, excess);
                    for (int c = 0; c < 3 && s > 0; ++c) result.at(x, y)[c] += (other.at(x, y)[c] - image.at(x, y)[c]) * s;
                }
        });
        out.set("image", std::move(result));
    }
};

WEFT_NODE(PreferUnbiased, "prefer-unbiased", 1)

}  // namespace
}  // namespace weft
