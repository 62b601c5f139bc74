// The sheared filter in two passes against the one in one.
#include "adaptive/lens_pieces.h"
#include "tests/adaptive/plane_samples.h"

namespace weft {
namespace {

Image slopes_of(const Samples& samples) {
    return RunNode("slope-bounds")
        .in("samples", samples)
        .set("effect", "lens")
        .out<Image>("slopes");
}
Image sheared(const Samples& samples, const Image& slopes, const char* lens, const char* fallback) {
    return RunNode("sheared-filter")
        .in("samples", samples)
        .in("slopes", slopes)
        .set("lens", lens)
        .set("fallback", fallback)
        .out<Image>("image");
}
Image factored(const Samples& samples, const Image& slopes, const char* order = "grid",
               const char* fallback = "pixel-mean", const char* port = "image") {
    return RunNode("factored-sheared")
        .in("samples", samples)
        .in("slopes", slopes)
        .set("order", order)
        .set("fallback", fallback)
        .out<Image>(port);
}

// Samples l x l a pixel, sample j l + i in row j of the lens; of one y and one v, unless jittered.
Samples grid_of_scene(BufferShape shape, int l, const Lens& lens, const SeenScene& scene,
                      double jitter = 0) {
    shape.spp = l * l;
    Samples out = samples_of_scene(shape, scene);
    out.lens = lens;
    std::mt19937 random(std::uint32_t(shape.seed));
    std::uniform_real_distribution<double> unit(0, 1);
    const size_t n = out.size();
    std::vector<float> xy(2 * n), uv(2 * n), rgb(3 * n), z(n);
    // The rows' places in the pixel, in an order unlike that on the lens.
    const auto shuffled = [l](int k) { return (k * (l - 1) + l / 2) % l; };
    for (size_t i = 0; i < n; ++i) {
        const int k = int(i) % (l * l), row = k / l, column = k % l;
        const size_t pixel = i / size_t(l * l);
        const auto at = [&](int cell) { return (cell + .5 + jitter * (unit(random) - .5)) / l; };
        const double x = double(pixel % size_t(shape.width)) + at(shuffled(column)),
                     y = double(pixel / size_t(shape.width)) + at(shuffled(row));
        // On a round lens or on the square one whose corners are on its rim.
        const double side = lens.blades == 4 ? std::sqrt(.5) : 1, v = side * (2 * at(row) - 1),
                     u = (lens.blades == 4 ? side : std::sqrt(1 - v * v)) * (2 * at(column) - 1);
        const SeenPoint seen = scene(x, y, .5, u, v);
        xy[2 * i] = float(x), xy[2 * i + 1] = float(y);
        uv[2 * i] = float(u), uv[2 * i + 1] = float(v);
        z[i] = float(seen.z);
        for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = float(seen.value * double(c + 1));
    }
    out.add("xy", 2, std::move(xy));
    out.add("uv", 2, std::move(uv));
    out.add("z", 1, std::move(z));
    out.add("rgb", 3, std::move(rgb));
    return out;
}
double difference(const Image& a, const Image& b) {
    double most = 0;
    for (size_t i = 0; i < a.pixels().size(); ++i)
        most = std::max(most, double(std::abs(a.pixels()[i] - b.pixels()[i])));
    return most;
}
// A plane out of focus by `coc` with two waves on it.
SeenScene waves(double coc, double L) {
    return [=](double x, double y, double, double u, double v) {
        return SeenPoint{.5 + .25 * std::sin(2 * pi_here * (x - coc * u) / L) +
                             .2 * std::sin(2 * pi_here * (y - coc * v) / (.7 * L)),
                         INFINITY};
    };
}
Lens square_lens() {
    Lens lens;
    lens.blades = 4, lens.rotation = float(pi_here / 4);
    return lens;
}

// Means and variances over u and v, however few the columns: of a disc 0 and 1/4, of a regular
// polygon on the unit circle 0 and (2 + cos(2 pi / n)) / 12.
TEST(LensPieces, hold_the_moments_of_their_lens) {
    for (int blades = 2; blades < 9; ++blades)
        for (const float turn : {0.0f, .3f, 2.0f})
            for (const size_t columns : {1, 3, 8, 16}) {
                Lens lens;
                lens.blades = blades < 3 ? 0 : blades, lens.rotation = turn;
                const adaptive::LensPieces pieces(lens, columns);
                double area = 0, u = 0, uu = 0, v = 0, vv = 0;
                for (size_t k = 0; k < columns; ++k) {
                    const auto across = pieces.column(k), along = pieces.v[k];
                    const auto power = [](adaptive::Interval of, int n) {
                        return (std::pow(double(of.b), n) - std::pow(double(of.a), n)) / n;
                    };
                    area += power(across, 1) * power(along, 1);
                    u += power(across, 2) * power(along, 1);
                    uu += power(across, 3) * power(along, 1);
                    v += power(across, 1) * power(along, 2);
                    vv += power(across, 1) * power(along, 3);
                }
                const double variance =
                    blades < 3 ? .25 : (2 + std::cos(2 * pi_here / blades)) / 12;
                EXPECT_NEAR(u / area, 0, 1e-3) << blades << " " << columns;
                EXPECT_NEAR(v / area, 0, 1e-3) << blades << " " << columns;
                EXPECT_NEAR(uu / area, variance, 1e-3) << blades << " " << columns;
                EXPECT_NEAR(vv / area, variance, 1e-3) << blades << " " << columns;
            }
}

// A round lens leaves 2 J1(a) / a of a wave, a = 2 pi C / L; pieces leave as much of all that a
// pixel resolves, L from 2 px.
TEST(LensPieces, leave_of_a_wave_what_their_lens_leaves) {
    const adaptive::LensCuts cuts{Lens{}};
    for (const double coc : {.2, .5, 1., 1.5, 2., 2.6, 4., 6.})
        for (double L = 2; L < 40; L *= 1.2) {
            const double a = 2 * pi_here * coc / L;
            const adaptive::LensPieces& pieces = cuts(float(coc));
            double over_u = 0, over_v = 0, area = 0;
            for (size_t k = 0; k < pieces.columns; ++k) {
                const auto across = pieces.column(k), along = pieces.v[k];
                const auto wave = [&](adaptive::Interval of) {
                    return (std::sin(a * double(of.b)) - std::sin(a * double(of.a))) / a;
                };
                const double width = double(across.length()), height = double(along.length());
                area += width * height;
                over_u += height * wave(across), over_v += width * wave(along);
            }
            const double left = 2 * std::cyl_bessel_j(1, a) / a;
            EXPECT_NEAR(over_u / area, left, .02) << coc << " " << L;
            EXPECT_NEAR(over_v / area, left, .02) << coc << " " << L;
        }
}

// Oracle: on a grid buffer the two passes are the one, to 1e-4.
TEST(FactoredSheared, of_a_grid_is_the_sheared_filter) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 16; ++i) {
        const int l = 2 + i % 4;
        Lens lens = i % 2 ? square_lens() : Lens{};
        lens.c1 = float(6 * unit(random) - 3);
        if (i % 3 == 0) lens.aspect = float(.6 + unit(random));
        const double coc = double(lens.c1);
        BufferShape shape{40, 32, 1, std::uint64_t(i + 1)};
        shape.moving = false, shape.c1 = lens.c1;
        const Samples samples = grid_of_scene(shape, l, lens, waves(coc, 5 + 10 * unit(random)));
        // Slopes known, and known less well than that.
        Image slopes = slopes_of(samples);
        const float off = i % 4 < 2 ? 0.0f : float(unit(random));
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 40; ++x) slopes.at(x, y)[0] -= off, slopes.at(x, y)[1] += off;
        EXPECT_LT(difference(factored(samples, slopes, "grid", "none"),
                             sheared(samples, slopes, "pieces", "none")),
                  1e-4)
            << "coc " << coc << ", l " << l << ", off " << off;
    }
}

// Where samples lie by chance within their strata, cells are no longer of one y and one v: the
// difference stays far below the noise that is left.
TEST(FactoredSheared, of_jittered_samples_is_as_good) {
    for (const double coc : {1., 3., 6.}) {
        BufferShape shape{48, 48, 1, 7};
        shape.moving = false, shape.c1 = float(coc);
        Lens lens;
        lens.c1 = float(coc);
        const Samples samples = grid_of_scene(shape, 4, lens, waves(coc, 24), 1);
        const Image slopes = slopes_of(samples);
        const double a = 2 * pi_here * coc / 24, b = a / .7;
        const auto exact = [&](int x, int y) {
            const auto wave = [](double at, double L, double angle) {
                return sinc(1 / L) * 2 * std::cyl_bessel_j(1, angle) / angle *
                       std::sin(2 * pi_here * at / L);
            };
            return .5 + .25 * wave(x + .5, 24, a) + .2 * wave(y + .5, .7 * 24, b);
        };
        const auto error = [&](const Image& image) { return rmse_of(image, exact, 12, 12); };
        const double one = error(sheared(samples, slopes, "closed", "pixel-mean")),
                     pieces = error(sheared(samples, slopes, "pieces", "pixel-mean")),
                     two = error(factored(samples, slopes)),
                     any = error(factored(samples, slopes, "any"));
        EXPECT_LT(pieces, 1.25 * one) << coc;
        EXPECT_LT(two, 1.15 * pieces + 2e-4) << coc;
        EXPECT_LT(any, 1.15 * pieces + 2e-4) << coc;
    }
}

// Oracle: a square lens of half width C leaves sinc(2 C / L) of a wave.
TEST(FactoredSheared, of_a_square_lens_is_what_it_leaves) {
    const double table[] = {.9003163, .6366198, .3001054, 0};
    for (int c = 1; c <= 4; ++c) {
        EXPECT_NEAR(sinc(2 * c / 8.), table[c - 1], 1e-7);
        Lens lens = square_lens();
        lens.c1 = float(c * std::sqrt(2.));  // the square's corners are on the rim
        BufferShape shape{48, 40, 1, std::uint64_t(c)};
        shape.moving = false, shape.c1 = lens.c1;
        const double coc = double(lens.c1);
        const Samples samples = grid_of_scene(
            shape, 3, lens,
            [&](double x, double, double, double u, double) {
                return SeenPoint{.5 + .5 * std::sin(2 * pi_here * (x - coc * u) / 8), INFINITY};
            },
            1);
        const Image slopes = slopes_of(samples);
        const auto exact = [&](int x, int) {
            return .5 + .5 * sinc(1 / 8.) * table[c - 1] * std::sin(2 * pi_here * (x + .5) / 8);
        };
        EXPECT_LT(rmse_of(factored(samples, slopes), exact, 12, 10), .02) << c;
        EXPECT_LT(rmse_of(sheared(samples, slopes, "closed", "pixel-mean"), exact, 12, 10), .02)
            << c;
    }
}

TEST(FactoredSheared, keeps_a_constant_to_the_bit) {
    for (int i = 0; i < 6; ++i) {
        BufferShape shape{24, 20, 4, std::uint64_t(i)};
        shape.moving = false, shape.c0 = 2.0f * float(i), shape.c1 = 1;
        const float value = .1f + .13f * float(i);
        const Samples samples =
            samples_of_scene(shape, [&](double x, double, double, double, double) {
                return SeenPoint{double(value), x < 12 ? 1. : 2.};
            });
        const Image out = factored(samples, slopes_of(samples), "any");
        for (const float kept : out.pixels()) ASSERT_EQ(kept, value);
    }
}

TEST(FactoredSheared, in_focus_is_the_pixels_own_mean) {
    BufferShape shape{16, 16, 4};
    shape.moving = false, shape.c1 = 1e-7f;
    const Samples samples = samples_of_scene(shape, grating(8, 0));
    const Image out = factored(samples, slopes_of(samples), "any", "none"),
                plain = RunNode("pixel-filter").in("samples", samples).out<Image>("image");
    EXPECT_LT(difference(out, plain), 1e-5);
}

TEST(FactoredSheared, says_what_it_needs) {
    const auto error = [](const Samples& samples, const char* effect, const char* order) {
        const Image slopes = RunNode("slope-bounds")
                                 .in("samples", samples)
                                 .set("effect", effect)
                                 .out<Image>("slopes");
        return error_of([&] { factored(samples, slopes, order); });
    };
    const auto says = [](const std::string& text, const char* part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    BufferShape shape{8, 8, 4};
    shape.c1 = 3;
    const Samples mixed = samples_of_scene(shape, grating(8, 1, 3));
    says(error(mixed, "lens", "grid"), "sample j 2 + i of each pixel in row j");
    says(error(mixed, "both", "any"), "the slopes hold motion");
    says(error(mixed, "motion", "any"), "the slopes hold no lens");
    shape.spp = 3;
    says(error(samples_of_scene(shape, grating(8, 1, 3)), "lens", "grid"),
         "l x l in each pixel; this buffer has 3 a pixel");
    shape.c1 = 0;
    const Samples pinhole = samples_of_scene(shape, grating(8, 1));
    says(error(pinhole, "lens", "any"), "'factored-sheared' needs uv");
}

}  // namespace
}  // namespace weft
