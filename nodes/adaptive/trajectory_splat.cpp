// trajectory-splat: each sample gives its radiance to all pixels that its own path crosses while
// the shutter is open, by the time that it spends in each: the sheared filter's limit where every
// sample knows its slope exactly. Nothing is hidden behind anything: what passes behind shines
// through, so it is good inside one surface.
// Source: derived from Egan et al. 2009, Sec. 4.  Cost: a clip for each pixel crossed.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "adaptive/sample_paths.h"
#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"
#include "samples/lens_shape.h"

namespace weft {
namespace {
using namespace adaptive;

constexpr int band = 16;  // rows that are filled together

// A sample's path, homogeneous: at time T it is at (x + T mx) / (w + T mw), y likewise.
struct Path {
    double x, y, w, mx, my, mw;
    std::array<double, 2> at(double T) const {
        const double inverse = 1 / (w + T * mw);
        return {(x + T * mx) * inverse, (y + T * my) * inverse};
    }
    // When it crosses x = b, or y = b; NaN or infinite where it does not.
    double when_x(double b) const { return (b * w - x) / (mx - b * mw); }
    double when_y(double b) const { return (b * w - y) / (my - b * mw); }
};

// work(cell, from, to) for the cells [k, k + 1) of an axis that it is in between two times, cells
// in [first, last]; `p0`, `p1`: where it is then; when(b): the time at which it passes b.
template <class When, class Work>
void each_cell(double p0, double p1, double T0, double T1, int first, int last, const When& when,
               const Work& work) {
    const double low = std::min(p0, p1), high = std::max(p0, p1);
    if (!(high >= first && low <= last + 1)) return;
    const int from = int(std::clamp(std::floor(low), double(first), double(last))),
              to = int(std::clamp(std::floor(high), double(first), double(last)));
    if (from == to && low >= from && high <= from + 1) return work(from, T0, T1);
    for (int k = from; k <= to; ++k) {
        // Times at which it passes both sides, in their order.
        double a = when(double(p0 <= p1 ? k : k + 1)), b = when(double(p0 <= p1 ? k + 1 : k));
        if (!(a > T0)) a = T0;
        if (!(b < T1)) b = T1;
        if (a < b) work(k, a, b);
    }
}

struct TrajectorySplat {
    static void declare(Ports<TrajectorySplat>& node) {
        node.about(
                "spreads each sample over the pixels that its own path crosses while the shutter "
                "is open")
            .in<Samples>("samples", "xy, z, rgb, t, motion (uv and a lens; weight)")
            .out<Image>("image", "R G B");
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"image", image_shape(s.width, s.height, 3)}},
                32.0 * double(s.width) * double(s.height) + 8.0 * double(s.records),
                300.0 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        samples.require("trajectory-splat", {"xy", "z", "rgb"});
        if (samples.domain != "camera")
            ctx.fail(
                fmt::format("needs a camera's samples, these are of domain '{}'", samples.domain));
        const SamplePaths paths(samples);
        const ShutterCurve shutter = shutter_of(samples.meta);
        const auto rgb = samples.rgb(), weight = samples.values("weight");
        const int width = samples.width, height = samples.height;

        // What a sample stands for, where pixels have more of them or fewer.
        std::vector<float> stands(weight.begin(), weight.end());
        if (stands.empty()) {
            stands.resize(samples.size());
            for (size_t pixel = 0; pixel < samples.pixels(); ++pixel) {
                const auto range = samples.of_pixel(pixel);
                for (size_t i = range.begin; i < range.end; ++i)
                    stands[i] = 1 / float(range.end - range.begin);
            }
        }
        // The samples whose paths cross each band of rows, in their order.
        std::vector<std::vector<std::uint32_t>> of_band(size_t((height + band - 1) / band));
        for (size_t i = 0; i < samples.size(); ++i) {
            if (!std::isfinite(rgb[3 * i] + rgb[3 * i + 1] + rgb[3 * i + 2])) continue;
            const Path path = path_of(paths, i);
            const Span open = shutter_span(path);
            if (open.empty()) continue;
            const double a = path.at(open.from)[1], b = path.at(open.to)[1];
            const double low = std::min(a, b), high = std::max(a, b);
            if (!(high >= 0 && low < height)) continue;
            const auto first = size_t(std::clamp(low, 0.0, height - 1.0)) / band,
                       last = size_t(std::clamp(high, 0.0, height - 1.0)) / band;
            for (size_t k = first; k <= last; ++k) of_band[k].push_back(std::uint32_t(i));
        }

        Image image(width, height, 3);
        image.color_space = samples.color_space;
        std::atomic<size_t> empty = 0, done = 0;
        ctx.parallel_for(of_band.size(), [&](size_t k) {
            const int first = int(k) * band, last = std::min(first + band, height) - 1;
            std::vector<std::array<double, 4>> sums(size_t(width) * band);
            for (const std::uint32_t i : of_band[k]) {
                const Path path = path_of(paths, i);
                const Span open = shutter_span(path);
                const double stand = double(stands[i]);
                const auto a = path.at(open.from), b = path.at(open.to);
                each_cell(
                    a[1], b[1], open.from, open.to, first, last,
                    [&](double y) { return path.when_y(y); },
                    [&](int row, double from, double to) {
                        each_cell(
                            path.at(from)[0], path.at(to)[0], from, to, 0, width - 1,
                            [&](double x) { return path.when_x(x); },
                            [&](int column, double T0, double T1) {
                                double w = stand * (T1 - T0);
                                if (!shutter.constant())
                                    w *= double(shutter.openness(float((T0 + T1) / 2)));
                                auto& sum =
                                    sums[size_t(row - first) * size_t(width) + size_t(column)];
                                for (size_t c = 0; c < 3; ++c) sum[c] += w * double(rgb[3 * i + c]);
                                sum[3] += w;
                            });
                    });
            }
            for (int y = first; y <= last; ++y)
                for (int x = 0; x < width; ++x) {
                    const auto& sum = sums[size_t(y - first) * size_t(width) + size_t(x)];
                    for (size_t c = 0; c < 3; ++c)
                        image.at(x, y)[c] = sum[3] > 0 ? float(sum[c] / sum[3]) : 0.0f;
                    empty += !(sum[3] > 0);
                }
            ctx.progress(double(++done), double(of_band.size()), "bands");
        });
        if (empty > 0)
            ctx.warn(fmt::format("no path crosses {} of {} pixels; they are black", size_t(empty),
                                 samples.pixels()));
        out.set("image", std::move(image));
    }

  private:
    // From the sample's own lens position.
    static Path path_of(const SamplePaths& paths, size_t i) {
        const auto m = paths.homogeneous_motion(i);
        const double t = double(paths.t(i)), w = double(paths.depth(i));
        const double mw = m[2];
        return {double(paths.x(i)) * w - t * m[0],
                double(paths.y(i)) * w - t * m[1],
                w - t * mw,
                m[0],
                m[1],
                mw};
    }
    // Of the shutter, the time that it is in front of the camera.
    struct Span {
        double from = 0, to = 1;
        bool empty() const { return !(from < to); }
    };
    static Span shutter_span(const Path& path) {
        Span span;
        const double least = 0.02 * std::max(path.w, path.w + path.mw);
        if (path.w < least) span.from = (least - path.w) / path.mw;
        if (path.w + path.mw < least) span.to = (least - path.w) / path.mw;
        if (!std::isfinite(path.x + path.y + path.w + path.mx + path.my + path.mw)) span.to = -1;
        return span;
    }
};

WEFT_NODE(TrajectorySplat, "trajectory-splat", 1)

}  // namespace
}  // namespace weft
