// cross-validate: how much of one picture is to be mixed into another, by samples that neither was
// made of. Both are made of each half of the samples, too (split-samples). With noise that knows
// nothing of either, means m of the other half tell errors apart: of low + s (high - low) the
// square error is the least, over both halves and the pixels around under a Gaussian, where
//     s = sum (high - low) (m - low) / sum (high - low)^2.
// Squares count relative to brightness. A single pixel's s is held within `limit` of 0 and 1, lest
// fireflies decide; and as few pixels leave s noisy, and edges are near, a narrow Gaussian and a
// wide one go together.
// Source: none of this form; two buffers of samples that judge each other are of Rousselle, Knaus
// and Zwicker 2012.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "filters/gaussian_filter_kernel.h"
#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/isa.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct CrossValidate {
    float sigma = 2, wide = 16, limit = 1, dark = 0.3f, otherwise = 0;

    static void declare(Ports<CrossValidate>& node) {
        node.about(
                "how much of one picture is to be mixed into another, by samples that neither was "
                "made of")
            .in<Image>("first-low", "the one picture, made of the first half of the samples; R G B")
            .in<Image>("first-high", "the other picture, made of that half; all of one size")
            .in<Image>("first-mean", "R G B, means of that half's samples (pixel-features)")
            .in<Image>("first-count", "how many these are")
            .in<Image>("second-low", "the same of the second half")
            .in<Image>("second-high", "the same of the second half")
            .in<Image>("second-mean", "R G B")
            .in<Image>("second-count", "how many these are")
            .out<Image>("share", "Y: 0 where 'low' is to be taken, 1 where 'high' is")
            .param("sigma", &CrossValidate::sigma,
                   {.unit = "px",
                    .min = 0.3,
                    .max = 64,
                    .about = "deviation of the narrow Gaussian that errors are summed up under"})
            .param("wide", &CrossValidate::wide,
                   {.unit = "px", .min = 0.3, .max = 64, .about = "of the wide one"})
            .param("limit", &CrossValidate::limit,
                   {.min = 0,
                    .max = 1e6,
                    .about = "how far below 0 and above 1 a single pixel's share may be: a low one "
                             "draws the share to 1/2 where means are very noisy"})
            .param("dark", &CrossValidate::dark,
                   {.unit = "mean of the picture",
                    .min = 1e-3,
                    .max = 1e3,
                    .about = "brightness below which errors no longer count relative to it"})
            .param("otherwise", &CrossValidate::otherwise,
                   {.min = 0,
                    .max = 1,
                    .about = "the share where no pixel around has samples in both halves"});
    }
    Cost cost(const Shapes& in) const { return cost_like(in, "first-low", "share", 1, 10, 1000); }

    struct Half {
        const Image &low, &high, &mean, &count;
    };
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const auto half = [&](const std::string& name) {
            const auto image = [&](const char* port) -> const Image& {
                return in.get<Image>(name + port);
            };
            return Half{image("-low"), image("-high"), image("-mean"), image("-count")};
        };
        const Half first = half("first"), second = half("second");
        const int width = first.low.width(), height = first.low.height();
        for (const Half* h : {&first, &second})
            for (const Image* i : {&h->low, &h->high, &h->mean, &h->count})
                if (i->width() != width || i->height() != height ||
                    i->channels() < (i == &h->count ? 1 : 3))
                    ctx.fail(fmt::format(
                        "a picture of {} x {} with {} channels beside {} x {}; expected one size, "
                        "R G B in pictures and means, and a channel in counts",
                        i->width(), i->height(), i->channels(), width, height));

        const float floor = dark * mean_of(first.low, ctx);
        // Per pixel numerator and denominator, and whether they are known.
        kernel::Planes sums(width, height, 3, 0), narrow(width, height, 3, 0),
            broad(width, height, 3, 0);
        ctx.parallel_rows(height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < width; ++x) {
                    const auto [over, under] = errors_of(first, second, x, y, floor);
                    sums.row(0, y)[x] = over;
                    sums.row(1, y)[x] = under;
                    sums.row(2, y)[x] =
                        *first.count.at(x, y) > 0 && *second.count.at(x, y) > 0 ? 1.0f : 0.0f;
                }
        });
        const std::vector<float> taps = kernel::gaussian_taps(sigma),
                                 wide_taps = kernel::gaussian_taps(wide);
        const auto rows_of = [] {
            using namespace kernel;
            return WEFT_PICK(gaussian_rows);
        }();
        Image share(width, height, std::vector<std::string>{"Y"});
        ctx.parallel_rows(height, [&](Rows rows) {
            rows_of(sums, 2, taps, rows.begin, rows.end, narrow);
            rows_of(sums, 2, wide_taps, rows.begin, rows.end, broad);
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < width; ++x) {
                    const float over = narrow.row(0, y)[x] + broad.row(0, y)[x],
                                under = narrow.row(1, y)[x] + broad.row(1, y)[x];
                    // Where both pictures are the same any share will do.
                    *share.at(x, y) = under > 0 ? std::clamp(over / under, 0.0f, 1.0f) : otherwise;
                }
        });
        out.set("share", std::move(share));
    }

  private:
    struct Errors {
        float over = 0, under = 0;
    };
    // Of both halves, each by the means of the other. Nothing is known where one has no samples, or
    // what it has is not finite.
    Errors errors_of(const Half& first, const Half& second, int x, int y, float floor) const {
        Errors all;
        if (!(*first.count.at(x, y) > 0) || !(*second.count.at(x, y) > 0)) return all;
        const auto add = [&](const Half& made, const Half& other, int c, float weight) {
            const float low = made.low.at(x, y)[c], change = made.high.at(x, y)[c] - low;
            all.over += weight * change * (other.mean.at(x, y)[c] - low);
            all.under += weight * change * change;
        };
        for (int c = 0; c < 3; ++c) {
            const float brightness = (first.low.at(x, y)[c] + first.high.at(x, y)[c] +
                                      second.low.at(x, y)[c] + second.high.at(x, y)[c]) /
                                     4,
                        weight = 1 / (brightness * brightness + floor * floor + 1e-20f);
            add(first, second, c, weight);
            add(second, first, c, weight);
        }
        if (!std::isfinite(all.over) || !std::isfinite(all.under)) return {};
        all.over = std::clamp(all.over, -limit * all.under, (1 + limit) * all.under);
        return all;
    }
    // Of what is finite.
    static float mean_of(const Image& image, Context& ctx) {
        struct Sum {
            double sum = 0, count = 0;
        };
        const auto width = size_t(image.width());
        const Sum all = ctx.reduce(
            size_t(image.height()), 16, Sum{},
            [&](size_t begin, size_t end) {
                Sum some;
                for (size_t y = begin; y < end; ++y)
                    for (size_t x = 0; x < width; ++x)
                        for (int c = 0; c < 3; ++c) {
                            const float v = image.at(int(x), int(y))[c];
                            if (std::isfinite(v)) some.sum += double(v), some.count += 1;
                        }
                return some;
            },
            [](Sum a, const Sum& b) {
                return Sum{a.sum + b.sum, a.count + b.count};
            });
        return float(all.sum / std::max(1.0, all.count));
    }
};

WEFT_NODE(CrossValidate, "cross-validate", 1)

}  // namespace
}  // namespace weft
