// How many times as fast as sheared-filter is factored-sheared, at equal output?
// Input: planes out of focus, 96 x 96, their circles of confusion of one radius or changing over
// the picture, a texture on them; 16 samples a pixel, 4 x 4 over the lens, jittered. Each node as
// its defaults are, one thread. Prints the median of 5 runs in microseconds of CPU a pixel, with
// their spread, their ratio, and both pictures' root mean square errors against the texture's own
// mean over pixel and lens.
#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "bench/cpu_time.h"
#include "tests/adaptive/plane_samples.h"

using namespace weft;

namespace {

constexpr int size = 96, side = 4, wavelength = 24;

// Circles of confusion from `near` at the left to `far` at the right.
Samples plane(double near, double far) {
    BufferShape shape{size, size, side * side};
    shape.moving = false, shape.c0 = 1, shape.c1 = 0;
    Samples out = samples_of_scene(shape, grating(wavelength, 0));
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    const size_t n = out.size();
    std::vector<float> xy(2 * n), uv(2 * n), z(n), rgb(3 * n);
    for (size_t i = 0; i < n; ++i) {
        const int k = int(i) % (side * side);
        const size_t pixel = i / (side * side);
        const double v = 2 * (k / side + unit(random)) / side - 1,
                     u = std::sqrt(1 - v * v) * (2 * (k % side + unit(random)) / side - 1);
        const double x = double(pixel % size) + unit(random),
                     y = double(pixel / size) + unit(random);
        // x = place + coc u, coc linear in place.
        const double grows = (far - near) / size, place = (x - near * u) / (1 + grows * u),
                     coc = near + grows * place;
        xy[2 * i] = float(x), xy[2 * i + 1] = float(y), uv[2 * i] = float(u);
        uv[2 * i + 1] = float(v), z[i] = float(1 / coc);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = float(.5 + .5 * std::sin(2 * pi_here * place / wavelength));
    }
    out.add("xy", 2, std::move(xy)), out.add("uv", 2, std::move(uv));
    out.add("z", 1, std::move(z)), out.add("rgb", 3, std::move(rgb));
    return out;
}

struct Timed {
    double median = 0, least = 0, most = 0;
    Image image;
};
Timed timed(const char* type, const Samples& samples, const Image& slopes) {
    Timed out;
    std::vector<double> runs;
    for (int run = 0; run < 5; ++run) {
        RunNode node(type);
        node.in("samples", samples).in("slopes", slopes);
        const double start = cpu_s();
        out.image = node.out<Image>("image");
        runs.push_back((cpu_s() - start) * 1e6 / (size * size));
    }
    std::sort(runs.begin(), runs.end());
    out.median = runs[2], out.least = runs[0], out.most = runs[4];
    return out;
}

}  // namespace

int main() {
    fmt::print("{:>12}{:>24}{:>24}{:>8}{:>20}\n", "circle, px", "sheared, us/pixel",
               "factored, us/pixel", "ratio", "errors");
    for (const auto& [near, far] : {std::pair{1., 1.}, {2., 2.}, {4., 4.}, {8., 8.}, {2., 8.}}) {
        const Samples samples = plane(near, far);
        const Image slopes = RunNode("slope-bounds")
                                 .in("samples", samples)
                                 .set("effect", "lens")
                                 .out<Image>("slopes");
        const Timed one = timed("sheared-filter", samples, slopes),
                    two = timed("factored-sheared", samples, slopes);
        // The texture's mean, over many points of pixel and lens.
        const auto exact = [&, near = near, far = far](int x, int) {
            double sum = 0;
            constexpr int n = 64;
            const double grows = (far - near) / size;
            for (int i = 0; i < n; ++i)
                for (int k = 0; k < n; ++k) {
                    const double at = x + (i + .5) / n, u = 2 * (k + .5) / n - 1;
                    const double place = (at - near * u) / (1 + grows * u);
                    sum += std::sqrt(1 - u * u) *
                           (.5 + .5 * std::sin(2 * pi_here * place / wavelength));
                }
            double area = 0;
            for (int k = 0; k < n; ++k) {
                const double u = 2 * (k + .5) / n - 1;
                area += n * std::sqrt(1 - u * u);
            }
            return sum / area;
        };
        fmt::print("{:>12}{:>24}{:>24}{:>8.1f}{:>20}\n", fmt::format("{} to {}", near, far),
                   fmt::format("{:.1f} ({:.1f}-{:.1f})", one.median, one.least, one.most),
                   fmt::format("{:.1f} ({:.1f}-{:.1f})", two.median, two.least, two.most),
                   one.median / two.median,
                   fmt::format("{:.4f} {:.4f}", rmse_of(one.image, exact, 24, 24),
                               rmse_of(two.image, exact, 24, 24)));
    }
}
