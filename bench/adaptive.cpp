// What does adaptive sampling cost beside the renderer, and reconstruction of what it sampled?
// Input: discs with a texture that move, are out of focus and change with the light, over a smooth
// background: a function of x, y and one to four axes that takes a few dozen ns. Pictures of 64 x
// 64 and 128 x 128 px, 4 to 16 samples a pixel, 3 to 6 axes. One thread. Prints the median of 5
// runs in CPU time, with their spread: ns a sample of adaptive-samples without the function itself,
// of structure-tensors and of leaf-integrate (given these), and million locations a second of
// anisotropic-reconstruct, 64 a pixel.
//   bench_adaptive [PX SAMPLES-A-PIXEL AXES]: all rows, or this one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "adaptive/leaf_tree.h"
#include "adaptive/metrics.h"
#include "adaptive/sampler_function.h"
#include "bench/cpu_time.h"
#include "image/image.h"
#include "light-field/streams.h"
#include "samples/random.h"
#include "tests/run_node.h"

using namespace weft;

namespace {

constexpr int runs = 5;

// Radiance at (x, y, t, u, v, light): a disc a tile of 48 px.
float radiance(const float* at, size_t axes) {
    constexpr float tau = 2 * std::numbers::pi_v<float>;
    const float t = at[2], u = axes > 4 ? at[3] - 0.5f : 0, v = axes > 4 ? at[4] - 0.5f : 0,
                light = axes % 2 == 0 ? at[axes - 1] : 1;
    const float x = at[0] - 6 * u, y = at[1] - 6 * v;
    const float dx = std::remainder(x - 10 - 28 * t, 48.0f), dy = std::remainder(y - 24, 48.0f);
    const float shade = std::clamp(3 * light - x / 32 + std::floor(x / 32), 0.0f, 1.0f);
    if (dx * dx + dy * dy < 81)
        return shade * (0.7f + 0.25f * std::sin(tau * dx / 6) * std::cos(tau * dy / 5));
    return shade * (0.3f + 0.2f * std::sin(tau * x / 24) * std::sin(tau * y / 20));
}

SamplerFunction sampler(int size, size_t axes) {
    SamplerFunction made;
    made.width = made.height = size;
    made.axes = {{"x", float(size)}, {"y", float(size)}, {"t", 28}};
    if (axes > 4) made.axes.insert(made.axes.end(), {{"u", 6}, {"v", 6}});
    if (axes % 2 == 0) made.axes.push_back({"light", 32});
    made.evaluate = [size, axes](const SamplerPoints& points, std::uint64_t, std::span<float> rgb) {
        for (size_t i = 0; i < points.size(); ++i) {
            float at[8] = {};
            for (size_t d = 0; d < axes; ++d) at[d] = points.axes[d][i] * (d < 2 ? float(size) : 1);
            for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = radiance(at, axes);
        }
    };
    return made;
}

struct Times {
    std::vector<double> of;
    void take(double s) { of.push_back(s), std::sort(of.begin(), of.end()); }
    double median() const { return of[of.size() / 2]; }
    std::string text(const std::function<double(double)>& unit, int digits) const {
        double least = unit(of.front()), most = unit(of.back());
        if (least > most) std::swap(least, most);
        return fmt::format("{:.{}f} ({:.{}f}-{:.{}f})", unit(median()), digits, least, digits, most,
                           digits);
    }
};
template <class Work>
double cpu_s_of(Work&& work) {
    const double start = cpu_s();
    work();
    return cpu_s() - start;
}

// Seconds of anisotropic-reconstruct: 64 locations a pixel, a tile of 32 x 32 px and a lens
// position, time and light at a time.
double reconstruct_s(const Samples& samples, const Metrics& tensors) {
    const NodeType* type = Registry::instance().type("anisotropic-reconstruct");
    const auto node = type->make(std::vector<Json>(type->decl().params.size()));
    const auto scratch = node->make_scratch();
    constexpr int tile = 32;
    Locations at;
    Colors colors;
    Inputs in;
    const auto link = [&](std::string_view port, const TypeInfo& of, const void* value) {
        void* object = const_cast<void*>(value);
        in.slots.push_back({port, &of, object, {object}});
    };
    link("locations", type_info<Locations>(), &at);
    link("samples", type_info<Samples>(), &samples);
    link("tensors", type_info<Metrics>(), &tensors);
    Outputs out;
    out.slots = {Slot{"colors", &type_info<Colors>(), &colors, {}}};
    double all = 0;
    at.shared = true;
    for (int y0 = 0; y0 < samples.height; y0 += tile)
        for (int x0 = 0; x0 < samples.width; x0 += tile)
            for (size_t slice = 0; slice < 64; ++slice) {
                const auto number = [&](size_t k) {
                    return unit_float(mix(mix(slice) ^ std::uint64_t(k)));
                };
                at.x0 = x0, at.y0 = y0, at.x1 = x0 + tile, at.y1 = y0 + tile, at.number = slice;
                at.t.assign(1, (float(slice) + 0.5f) / 64);
                at.u.assign(1, number(0) - 0.5f), at.v.assign(1, number(1) - 0.5f);
                at.x.resize(tile * tile), at.y.resize(tile * tile),
                    at.own_pixels.resize(tile * tile);
                for (size_t i = 0; i < tile * tile; ++i) {
                    at.x[i] = float(x0) + float(i % tile) + number(2 * i + 2);
                    at.y[i] = float(y0) + float(i / tile) + number(2 * i + 3);
                    at.own_pixels[i] =
                        std::uint32_t((y0 + int(i) / tile) * samples.width + x0 + int(i) % tile);
                }
                at.pixels = at.own_pixels;
                const double start = cpu_s();
                node->batch(in, out, scratch.get());
                all += cpu_s() - start;
            }
    return all;
}

void row(int size, size_t axes, double budget) {
    const SamplerFunction of = sampler(size, axes);
    Samples samples;
    LeafTree leaves;
    Metrics tensors;
    Times function, sampling, ways, boxes, colors;
    for (int run = 0; run < runs; ++run) {
        RunNode take("adaptive-samples");
        take.in("sampler", of).set("budget", Json(budget));
        samples = {}, leaves = {};
        sampling.take(cpu_s_of([&] {
            take.run({Slot{"samples", &type_info<Samples>(), &samples, {}},
                      Slot{"leaves", &type_info<LeafTree>(), &leaves, {}}});
        }));
        std::vector<std::vector<float>> points(axes, std::vector<float>(samples.size()));
        for (size_t i = 0; i < samples.size(); ++i)
            for (size_t d = 0; d < axes; ++d)
                points[d][i] = std::fmod(float(i) * (0.1f + 0.01f * float(d)), 1.0f);
        const std::vector<std::span<const float>> views(points.begin(), points.end());
        std::vector<float> rgb(3 * samples.size());
        function.take(cpu_s_of([&] { of.evaluate({views}, 0, rgb); }));
        ways.take(cpu_s_of([&] {
            tensors = RunNode("structure-tensors")
                          .in("samples", samples)
                          .in("leaves", leaves)
                          .out<Metrics>("tensors");
        }));
        boxes.take(cpu_s_of([&] {
            RunNode("leaf-integrate")
                .in("samples", samples)
                .in("leaves", leaves)
                .in("tensors", tensors)
                .out<Image>("image");
        }));
        colors.take(reconstruct_s(samples, tensors));
    }
    Times own;
    for (const double s : sampling.of) own.take(s - function.median());
    const double n = double(samples.size()), locations = 64.0 * size * size;
    const auto ns = [&](double s) { return s * 1e9 / n; };
    fmt::print("{:>5}{:>6}{:>6}{:>22}{:>22}{:>22}{:>22}\n", size, budget, axes, own.text(ns, 0),
               ways.text(ns, 0), boxes.text(ns, 0),
               colors.text([&](double s) { return locations * 1e-6 / s; }, 2));
}

}  // namespace

int main(int argc, char** argv) {
    fmt::print("{:>5}{:>6}{:>6}{:>22}{:>22}{:>22}{:>22}\n", "px", "spp", "axes", "sampling, ns",
               "tensors, ns", "leaves, ns", "M locations/s");
    if (argc == 4) {  // one row: px, samples a pixel, axes
        row(std::atoi(argv[1]), std::min<size_t>(6, std::stoul(argv[3])), std::atof(argv[2]));
        return 0;
    }
    for (const int axes : {3, 4, 5, 6}) row(64, size_t(axes), 8);
    for (const double budget : {4.0, 16.0}) row(64, 3, budget);
    row(128, 3, 8);
}
