// Sample buffers whose pictures are known: planes that face the camera, moving and out of focus,
// with a texture that moves along.
#pragma once
#include <cmath>
#include <functional>
#include <random>

#include "image/image.h"
#include "samples/lens_shape.h"
#include "samples/samplers.h"
#include "samples/samples.h"
#include "tests/run_node.h"

namespace weft {

inline constexpr double pi_here = 3.14159265358979323846;

// What a ray sees: its radiance (all channels), depth, and velocity, px a shutter.
struct SeenPoint {
    double value = 0, z = 1, vx = 0, vy = 0;
};
// At film position (x, y), time t, from lens position (u, v).
using SeenScene = std::function<SeenPoint(double x, double y, double t, double u, double v)>;

struct BufferShape {
    int width = 48, height = 4, spp = 4;
    std::uint64_t seed = 1;
    float c0 = 0, c1 = 0;  // of the lens; 0: a pinhole
    bool moving = true;
};

inline Samples samples_of_scene(const BufferShape& shape, const SeenScene& scene) {
    Samples out;
    out.width = shape.width, out.height = shape.height, out.spp = shape.spp;
    const size_t n = size_t(shape.width) * size_t(shape.height) * size_t(shape.spp);
    out.set_size(n);
    const bool lens = shape.c0 != 0 || shape.c1 != 0;
    if (lens) out.lens = Lens{shape.c0, shape.c1};
    std::vector<float> xy(2 * n), uv(2 * n), t(n), z(n), motion(3 * n), rgb(3 * n);
    size_t i = 0;
    for (int y = 0; y < shape.height; ++y)
        for (int x = 0; x < shape.width; ++x) {
            const SampleSequence numbers =
                sample_sequence(Sampler::sobol, shape.seed, x, y, shape.spp);
            for (int s = 0; s < shape.spp; ++s, ++i) {
                const Disk film = numbers(std::uint32_t(s), 0), on = numbers(std::uint32_t(s), 1),
                           time = numbers(std::uint32_t(s), 2);
                xy[2 * i] = float(x) + film.u, xy[2 * i + 1] = float(y) + film.v;
                const auto place = on_lens(on.u, on.v, Lens{});
                uv[2 * i] = place[0], uv[2 * i + 1] = place[1];
                t[i] = time.u;
                const SeenPoint seen =
                    scene(double(xy[2 * i]), double(xy[2 * i + 1]), double(t[i]),
                          double(lens ? place[0] : 0.0f), double(lens ? place[1] : 0.0f));
                z[i] = float(seen.z);
                motion[3 * i] = float(seen.vx * (std::isfinite(seen.z) ? seen.z : 1));
                motion[3 * i + 1] = float(seen.vy * (std::isfinite(seen.z) ? seen.z : 1));
                for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = float(seen.value);
            }
        }
    out.add("xy", 2, std::move(xy));
    if (lens) out.add("uv", 2, std::move(uv));
    out.add("z", 1, std::move(z));
    if (shape.moving) {
        out.add("t", 1, std::move(t));
        out.add("motion", 3, std::move(motion));
    }
    out.add("rgb", 3, std::move(rgb));
    out.meta = out.meta_object();
    return out;
}

// A vertical grating of wavelength L that moves by v, seen through a lens: x = place + v t + coc u.
inline SeenScene grating(double L, double v, double coc = 0, double phase = 0) {
    return [=](double x, double, double t, double u, double) {
        return SeenPoint{.5 + .5 * std::sin(2 * pi_here * (x - v * t - coc * u) / L + phase), 1, v,
                         0};
    };
}
inline double sinc(double x) {
    return x == 0 ? 1 : std::sin(pi_here * x) / (pi_here * x);
}
// Its picture: box pixel, box shutter, round lens.
inline double grating_pixel(int i, double L, double v, double coc = 0, double phase = 0) {
    const double a = 2 * pi_here * coc / L;
    const double lens = coc == 0 ? 1 : 2 * std::cyl_bessel_j(1, std::abs(a)) / std::abs(a);
    return .5 +
           .5 * sinc(v / L) * sinc(1 / L) * lens *
               std::sin(2 * pi_here * (i + .5 - v / 2) / L + phase);
}

// Root mean square over pixels at least `margin` from the picture's sides, and `rows` from its top
// and bottom.
inline double rmse_of(const Image& image, const std::function<double(int x, int y)>& exact,
                      int margin = 0, int rows = 0) {
    double sum = 0;
    int n = 0;
    for (int y = rows; y < image.height() - rows; ++y)
        for (int x = margin; x < image.width() - margin; ++x, ++n) {
            const double d = double(*image.at(x, y)) - exact(x, y);
            sum += d * d;
        }
    return std::sqrt(sum / n);
}

}  // namespace weft
