// How fast are the kernels of light-field reconstruction in one hand-written loop?
//   bench_tlfr_loop SAMPLES.npz [REFERENCE.exr] [--locations N] [--repeat N] [--block N] [--exponent P] ...
// Prints nanoseconds a location, all in and by kernel, the median of --repeat runs with its range, and
// relMSE against the reference. One thread. bench_tlfr_segment holds the same kernels as separate nodes
// against it.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "bench/tlfr_loop.h"
#include "image/picture_file.h"
#include "light-field/smooth_radiance_kernel.h"
#include "samples/sample_file.h"

namespace {

using namespace weft;
using namespace weft::light_field;

struct Options : LoopOptions {
    int repeat = 1;
    bool smooth = false;
    float widest = 4.5f, caution = 0.5f, sharp_caution = 2;
};

double relmse(const std::vector<float>& sums, const Image& reference) {
    double error = 0;
    size_t n = 0;
    for (int y = 0; y < reference.height(); ++y)
        for (int x = 0; x < reference.width(); ++x)
            for (int c = 0; c < 3; ++c, ++n) {
                const float* sum = &sums[4 * (size_t(y) * size_t(reference.width()) + size_t(x))];
                const double a = sum[3] > 0 ? double(sum[c]) / double(sum[3]) : 0, b = reference.at(x, y)[c];
                error += (a - b) * (a - b) / (b * b + 0.01);
            }
    return error / double(n);
}

}  // namespace

int main(int argc, char** argv) {
    Options o;
    std::vector<std::string> files;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        if (!key.starts_with("--")) {
            files.push_back(key);
            continue;
        }
        const double value = i + 1 < argc ? std::atof(argv[++i]) : 0;
        if (key == "--locations") o.locations = std::uint32_t(value);
        else if (key == "--per-slice") o.per_slice = std::uint32_t(value);
        else if (key == "--block") o.block = int(value);
        else if (key == "--sets") o.sets = int(value);
        else if (key == "--repeat") o.repeat = int(value);
        else if (key == "--exponent") o.exponent = float(value);
        else if (key == "--radius") o.radius = float(value);
        else if (key == "--filter-radius") o.filter_radius = float(value);
        else if (key == "--tolerance") o.test.tolerance = float(value);
        else if (key == "--box") o.test.box = float(value);
        else if (key == "--stages") o.stages = value != 0;
        else if (key == "--smooth") o.smooth = value != 0;
        else if (key == "--widest") o.widest = float(value);
        else if (key == "--sharp-caution") o.sharp_caution = float(value);
        else if (key == "--caution") o.caution = float(value);
        else if (key == "--isa") pin_isa(Isa(int(value)));
        else return fmt::print(stderr, "unknown option {}\n", key), 2;
    }
    if (files.empty()) return fmt::print(stderr, "usage: bench_tlfr_loop SAMPLES.npz [REFERENCE.exr] [options]\n"), 2;
    PlainContext ctx;
    Samples samples = read_sample_file(map_file(files[0]), ReadOptions(), ctx);
    double smooth = cpu_ns();
    if (o.smooth) {
        Smoothing by;
        by.caution = o.caution;
        by.sharp_caution = o.sharp_caution;
        samples.add(Channel{
            "rgb",
            3,
            standard_role("rgb"),
            smooth_radiance(samples, std::array{samples.rgb()}, dispersion_radius(samples.mean_spp()),
                            o.widest, by, ctx)[0],
            {}});
    }
    smooth = cpu_ns() - smooth;
    double build = cpu_ns();
    const Hierarchy h = build_hierarchy(samples, Arrangement::layers, 1, ctx);
    build = cpu_ns() - build;
    std::vector<double> took;
    for (int i = 0; i < o.repeat; ++i) {
        Loop loop(h, o);
        const double start = cpu_ns();
        loop.run();
        took.push_back((cpu_ns() - start) / double(loop.locations));
        if (i + 1 < o.repeat) continue;
        const double n = double(loop.locations);
        std::sort(took.begin(), took.end());
        fmt::print("{:.1f} ns/location (median; {:.1f} to {:.1f}), build {:.1f} smooth {:.1f} ns/sample;", took[took.size() / 2],
                   took.front(), took.back(), build / double(h.size()), smooth / double(h.size()));
        if (o.stages)
            for (size_t k = 0; k < kernels; ++k) fmt::print(" {} {:.1f}", kernel_names[k], loop.ns[k] / n);
        fmt::print("; candidates {:.1f} projected {:.1f} slow {:.2f}% retried {:.2f}% empty {:.3f}%", double(loop.candidates) / n,
                   double(loop.projected) / n, 100 * double(loop.slow) / n, 100 * double(loop.retried) / n, 100 * double(loop.empty) / n);
        if (files.size() > 1) fmt::print("; relMSE {:.5f}", relmse(loop.sums, read_picture(files[1])));
        fmt::print("\n");
    }
}
