// render-image: a converged picture by the renderer of render-samples, with its own estimate of
// error. Passes of 16 samples a pixel until a stopping rule holds. Deterministic by `spp` and by
// `relative-error`, which looks at whole passes; by `seconds` it is not.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "image/image_cost.h"
#include "render/render_node.h"
#include "render/sample_buffer.h"

namespace weft::render {
namespace {

// Of a pixel: sums of its samples, of their squares, and of every second one.
struct PixelSums {
    double color[3] = {}, square[3] = {}, even[3] = {};
    double alpha = 0;
    std::uint64_t count = 0;
};

struct RenderImage : RenderNode {
    int spp = 256;
    float relative_error = 0;
    double seconds = 0;
    bool alpha = false;
    std::shared_ptr<Prepared> prepared = std::make_shared<Prepared>();

    static void declare(Ports<RenderImage>& node) {
        node.about(
                "renders a scene to a picture (box filter), with variance and two independent "
                "halves")
            .in<Scene>("scene", "what to render, from its camera")
            .out<Image>("image", "the mean of all samples, scene-linear")
            .out<Image>("variance",
                        "of each pixel's mean, estimated from its samples' spread; sobol does "
                        "better than that")
            .out<Image>("half-a", "the mean of samples 0, 2, 4, ...")
            .out<Image>("half-b",
                        "the mean of samples 1, 3, 5, ...: its difference from half-a is noise")
            .param(
                "spp", &RenderImage::spp,
                {.unit = "samples", .min = 1, .max = 1 << 20, .about = "samples a pixel, at most"})
            .param("relative-error", &RenderImage::relative_error,
                   {.min = 0,
                    .max = 10,
                    .about = "stops where the root of the pixels' mean variance / (mean^2 + 0.01) "
                             "is below this; 0: not asked"})
            .param("seconds", &RenderImage::seconds,
                   {.unit = "s",
                    .min = 0,
                    .max = 1e9,
                    .about = "stops after the pass in which this is over; 0: not asked"})
            .param("alpha", &RenderImage::alpha, {.about = "adds coverage as A"});
        declare_shared(node);
    }

    Cost cost(const Shapes&) const {
        const Shape picture = image_shape(width, height, 3 + alpha);
        const double pixels = double(width) * double(height);
        return {{{"image", picture},
                 {"variance", image_shape(width, height, 3)},
                 {"half-a", image_shape(width, height, 3)},
                 {"half-b", image_shape(width, height, 3)}},
                pixels * sizeof(PixelSums) + 16e6,
                pixels * spp * 1000};
    }

    std::shared_ptr<Prepared::Made> prepare(const Inputs& in, Context& ctx) const {
        const Scene& scene = in.get<Scene>("scene");
        return prepared->get(scene, [&] {
            RenderOptions o = options();
            const std::vector<std::string> names{"rgb", "alpha"};
            o.channels = channel_set(names, false, false);
            return std::make_shared<Prepared::Made>(scene, o, SamplePlan(width, height, spp), ctx);
        });
    }

    // Samples [first, first + count) of the pixels of rows [begin, end), added to `sums`.
    static void add_pass(Prepared::Made& made, int begin, int end, std::uint32_t first,
                         std::uint32_t count, std::vector<PixelSums>& sums, Context& ctx) {
        const int wide = made.plan.width();
        const int across = (wide + pixels_in_piece - 1) / pixels_in_piece;
        ctx.parallel_for(size_t(across) * size_t(end - begin), [&](size_t piece) {
            const int y = begin + int(piece / size_t(across)),
                      x = int(piece % size_t(across)) * pixels_in_piece;
            made.workers.with([&](RenderWorker& worker) {
                BatchCursor cursor(made.plan, {x, y, std::min(x + pixels_in_piece, wide), y + 1},
                                   first, count);
                while (cursor.next(worker.runs)) {
                    ctx.check_cancelled();
                    made.tracer.render(worker.runs, *worker.workspace, worker.batch);
                    size_t i = 0;
                    for (const PixelRun& run : worker.runs) {
                        PixelSums& to = sums[size_t(run.y - begin) * size_t(wide) + size_t(run.x)];
                        for (std::uint32_t s = 0; s < run.count; ++s, ++i) {
                            const float* rgb = worker.batch.at(ChannelId::rgb, i);
                            for (int c = 0; c < 3; ++c) {
                                const double v = double(rgb[c]);
                                to.color[c] += v, to.square[c] += v * v;
                                if ((run.first + s) % 2 == 0) to.even[c] += v;
                            }
                            to.alpha += double(*worker.batch.at(ChannelId::alpha, i));
                            ++to.count;
                        }
                    }
                }
            });
        });
    }

    static double variance_of_mean(const PixelSums& p, int c) {
        const double n = double(p.count);
        if (n < 2) return 0;
        const double mean = p.color[c] / n;
        return std::max(0.0, p.square[c] / n - mean * mean) / (n - 1);
    }
    static double error_of(const std::vector<PixelSums>& sums) {
        double error = 0;
        for (const PixelSums& p : sums)
            for (int c = 0; c < 3; ++c) {
                const double mean = p.color[c] / double(p.count);
                error += variance_of_mean(p, c) / (mean * mean + 0.01);
            }
        return std::sqrt(error / double(3 * sums.size()));
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        prepared->release();
        const auto made = prepare(in, ctx);
        std::vector<PixelSums> sums(size_t(width) * size_t(height));
        const auto start = std::chrono::steady_clock::now();
        double error = -1;
        for (std::uint32_t first = 0; first < std::uint32_t(spp); first += samples_in_packet) {
            add_pass(*made, 0, height, first, samples_in_packet, sums, ctx);
            ctx.progress(std::min(double(first + samples_in_packet), double(spp)), spp,
                         "samples a pixel");
            const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
            if (seconds > 0 && took.count() >= seconds) break;
            if (relative_error > 0 && (error = error_of(sums)) <= double(relative_error)) break;
        }
        if (relative_error > 0 && error > double(relative_error))
            ctx.warn(
                fmt::format("after {} samples a pixel the relative error is {:.3g}, not the {:.3g} "
                            "asked for; raise "
                            "'spp' or 'seconds'",
                            sums[0].count, error, relative_error));
        prepared->release();
        give(sums, made->tracer.scene().color_space, out, ctx);
    }

    void give(const std::vector<PixelSums>& sums, const std::string& space, Outputs& out,
              Context& ctx) const {
        Image image(width, height, 3 + alpha), variance(width, height, 3), a(width, height, 3),
            b(width, height, 3);
        for (Image* picture : {&image, &a, &b}) picture->color_space = space;
        variance.color_space = "Raw";
        ctx.parallel_rows(height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < width; ++x) {
                    const PixelSums& p = sums[size_t(y) * size_t(width) + size_t(x)];
                    const double n = double(p.count), even = double((p.count + 1) / 2),
                                 odd = double(p.count / 2);
                    for (int c = 0; c < 3; ++c) {
                        image.at(x, y)[c] = float(p.color[c] / n);
                        variance.at(x, y)[c] = float(variance_of_mean(p, c));
                        a.at(x, y)[c] = float(p.even[c] / even);
                        b.at(x, y)[c] =
                            odd > 0 ? float((p.color[c] - p.even[c]) / odd) : a.at(x, y)[c];
                    }
                    if (alpha) image.at(x, y)[3] = float(p.alpha / n);
                }
        });
        const auto put = [&](const char* port, Image& picture) {
            if (out.wanted(port)) out.set(port, std::move(picture));
        };
        put("image", image), put("variance", variance), put("half-a", a), put("half-b", b);
    }

    // Shards: bands of rows, where the number of samples is known beforehand.
    static constexpr int rows_in_piece = 16;
    bool divides() const { return relative_error == 0 && seconds == 0; }
    size_t pieces(const Inputs&) const {
        prepared->release();  // another run may have another scene, at the same place
        return size_t(height + rows_in_piece - 1) / rows_in_piece;
    }
    void piece(const Inputs& in, size_t index, ByteWriter& to, Context& ctx) const {
        // One piece prepares while others wait for it: it must not take up their work meanwhile.
        PlainContext alone;
        const auto made = prepare(in, alone);
        const int begin = int(index) * rows_in_piece, end = std::min(begin + rows_in_piece, height);
        std::vector<PixelSums> sums(size_t(width) * size_t(end - begin));
        for (std::uint32_t first = 0; first < std::uint32_t(spp); first += samples_in_packet)
            add_pass(*made, begin, end, first, samples_in_packet, sums, ctx);
        to.put_text(made->tracer.scene().color_space);
        to.put_all(sums);
    }
    void join(const Pieces& all, Outputs& out, Context& ctx) const {
        std::vector<PixelSums> sums(size_t(width) * size_t(height));
        std::string space;
        const size_t band = size_t(width) * rows_in_piece;
        for (size_t i = 0; i < all.size(); ++i) {
            ByteReader from = all.read(i);
            space = from.take_text();
            if (i * band >= sums.size()) throw Error("holds more rows than the picture has");
            from.fill(std::span(sums).subspan(i * band, std::min(band, sums.size() - i * band)));
        }
        give(sums, space, out, ctx);
    }
};

WEFT_NODE(RenderImage, "render-image", 3);

}  // namespace
}  // namespace weft::render
