// The sheared filter against pictures that are known exactly.
#include "adaptive/path_sums.h"
#include "adaptive/sheared_weights.h"
#include "tests/adaptive/plane_samples.h"

namespace weft {
namespace {

Image slopes_of(const Samples& samples, const char* effect = "both") {
    return RunNode("slope-bounds")
        .in("samples", samples)
        .set("effect", effect)
        .out<Image>("slopes");
}
Image sheared(const Samples& samples, const char* effect = "both", const char* port = "image") {
    return RunNode("sheared-filter")
        .in("samples", samples)
        .in("slopes", slopes_of(samples, effect))
        .out<Image>(port);
}
Image box(const Samples& samples) {
    return RunNode("pixel-filter").in("samples", samples).out<Image>("image");
}

TEST(ShearedWeights, are_their_integrals) {
    EXPECT_NEAR(adaptive::gaussian_over_window(.4, .5, .3, .8, 1.2, 1), .4391773, 5e-8);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 100; ++i) {
        const double D = unit(random), Y = unit(random), sx = .1 + .4 * std::abs(unit(random)),
                     sy = .1 + std::abs(unit(random)), s = 2 * unit(random),
                     A = .5 + std::abs(unit(random));
        double sum = 0;
        constexpr int n = 20000;
        for (int k = 0; k < n; ++k) {
            const double y = A * ((k + .5) / n * 2 - 1), across = D + s * (Y - y);
            sum += std::exp(-across * across / (2 * sx * sx) - (Y - y) * (Y - y) / (2 * sy * sy));
        }
        EXPECT_NEAR(adaptive::gaussian_over_window(D, Y, sx, sy, s, A), sum * 2 * A / n, 1e-6);
    }
    for (int i = 0; i < 100; ++i) {
        const auto interval = [&] {
            const double a = 1.3 * unit(random), b = 1.3 * unit(random);
            return adaptive::Interval{float(std::min(a, b)), float(std::max(a, b)) + .01f};
        };
        const adaptive::Interval x = interval(), y = interval();
        int on = 0;
        constexpr int n = 400;
        for (int j = 0; j < n; ++j)
            for (int k = 0; k < n; ++k)
                on += std::hypot(x.a + x.length() * (j + .5f) / n,
                                 y.a + y.length() * (k + .5f) / n) < 1;
        EXPECT_NEAR(adaptive::share_on_disc(x, y), double(on) / (n * n), 4e-3);
    }
}

// Whatever the weights and wherever samples lie.
TEST(PathSums, of_cubics_are_exact_and_few_keep_their_mean) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 50; ++i) {
        const double second = .1 + 4 * unit(random), third = unit(random) - .5, a = unit(random),
                     b = unit(random), c = unit(random), d = unit(random), e = unit(random);
        adaptive::PathSums sums(second, third);
        const float bounds[] = {-1000, 1000};  // so that nothing is clamped
        for (const float& bound : bounds) sums.add(0, std::array{bound, bound, bound}.data(), 0, 0);
        for (int k = 0; k < 30; ++k) {
            const double s = 3 * unit(random) - 1, aside = unit(random);
            const auto value = float(a + s * (b + s * (c + s * d)) + e * aside);
            sums.add(.5 + unit(random), std::array{value, 2 * value, 1.0f}.data(), s, aside);
        }
        const auto mean = sums.fitted();
        EXPECT_NEAR(mean[0], a + c * second + d * third, 1e-4);
        EXPECT_NEAR(mean[1], 2 * (a + c * second + d * third), 2e-4);
        EXPECT_NEAR(mean[2], 1, 1e-9);
    }
    adaptive::PathSums few(1, 0);
    EXPECT_EQ(few.effective(), 0);
    const float color[] = {1, 2, 3}, other[] = {3, 4, 5};
    few.add(1, color, -1, 0), few.add(1, other, .5, 0);
    EXPECT_EQ(few.effective(), 2);
    EXPECT_EQ(few.fitted(), (std::array<double, 3>{2, 3, 4}));
}

struct Wave {
    double L, v;
};
const Wave waves[] = {{8, 6}, {16, 24}, {4, 3}};

// Oracle: a moving texture. Where slopes are exact, four samples a pixel are enough.
TEST(ShearedFilter, of_a_moving_texture_is_far_better_than_its_samples) {
    EXPECT_NEAR(.5 * sinc(6 / 8.) * sinc(1 / 8.), .14622568, 1e-8);
    double worst = 0;
    for (const Wave& w : waves) {
        double filtered = 0, plain = 0;
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            // Independent rows: one-dimensional pictures.
            BufferShape shape{96, 16, 4, seed};
            const Samples samples = samples_of_scene(shape, grating(w.L, w.v));
            const auto exact = [&](int x, int) { return grating_pixel(x, w.L, w.v); };
            filtered += std::pow(rmse_of(sheared(samples), exact, 25), 2) / 4;
            plain += std::pow(rmse_of(box(samples), exact, 25), 2) / 4;
        }
        RecordProperty("sheared_" + std::to_string(int(w.L)), std::to_string(std::sqrt(filtered)));
        RecordProperty("plain_" + std::to_string(int(w.L)), std::to_string(std::sqrt(plain)));
        EXPECT_LT(std::sqrt(filtered), .035) << w.L << ", plain " << std::sqrt(plain);
        worst = std::max(worst, std::sqrt(filtered / plain));
    }
    EXPECT_LT(worst, .3);
}

// Any other texture that moves: speeds, ways, wavelengths, phases, seeds.
TEST(ShearedFilter, of_random_moving_textures_is_as_good) {
    std::mt19937 random(21);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 24; ++i) {
        const double L = 4 + 20 * unit(random), v = (i % 2 ? 1 : -1) * (3 + 21 * unit(random)),
                     phase = 2 * pi_here * unit(random);
        const Samples samples =
            samples_of_scene({96, 24, 4, std::uint64_t(i + 1)}, grating(L, v, 0, phase));
        const auto exact = [&](int x, int) { return grating_pixel(x, L, v, 0, phase); };
        const double filtered = rmse_of(sheared(samples), exact, 25),
                     plain = rmse_of(box(samples), exact, 25);
        if (plain < .13) {
            EXPECT_LT(filtered, .035) << "L " << L << ", v " << v << ", plain " << plain;
        }
        EXPECT_LT(filtered, .3 * plain) << "L " << L << ", v " << v;
    }
}

// Dense limit: the exact picture, but for the blur that the filter is known to have.
TEST(ShearedFilter, of_many_samples_is_exact) {
    for (const Wave& w : waves) {
        BufferShape shape{64, 2, 1024};
        const Samples samples = samples_of_scene(shape, grating(w.L, w.v));
        const double band = std::min(.5, 1 / w.v), sigma = .08 * std::sqrt(1 / (band * band) - 4),
                     blur = std::exp(-2 * pi_here * pi_here * sigma * sigma / (w.L * w.L));
        const Image out = sheared(samples);
        for (int x = 25; x < 39; ++x)
            EXPECT_NEAR(*out.at(x, 0), .5 + blur * (grating_pixel(x, w.L, w.v) - .5), .01)
                << w.L << " " << w.v;
    }
    const Samples still = samples_of_scene({64, 2, 1024}, grating(8, 0));
    const Image out = sheared(still);
    for (int x = 0; x < 64; ++x) EXPECT_NEAR(*out.at(x, 0), grating_pixel(x, 8, 0), 2e-3);
}

// Oracle: defocus of one plane, and both at once.
TEST(ShearedFilter, of_defocus_and_of_both_is_what_disc_and_shutter_leave) {
    for (const auto& [coc, share] :
         {std::pair{1., .92485024}, {2., .72170284}, {3., .44923315}, {4., .18119175}}) {
        EXPECT_NEAR(2 * std::cyl_bessel_j(1, 2 * pi_here * coc / 8) / (2 * pi_here * coc / 8),
                    share, 1e-7);
        for (const double v : {0., 3.}) {
            BufferShape shape{48, 40, 4};
            shape.c1 = float(coc);
            const auto scene = [&](double x, double, double t, double u, double) {
                return SeenPoint{.5 + .5 * std::sin(2 * pi_here * (x - v * t - coc * u) / 8),
                                 INFINITY, v, 0};
            };
            const Samples samples = samples_of_scene(shape, scene);
            const auto exact = [&](int x, int) { return grating_pixel(x, 8, v, coc); };
            const Image out = sheared(samples);
            const double filtered = rmse_of(out, exact, 12, 10),
                         plain = rmse_of(box(samples), exact, 12, 10);
            EXPECT_LT(filtered, .025) << coc << " " << v << ", plain " << plain;
            EXPECT_LT(filtered, plain) << coc << " " << v;
        }
    }
}

// Planes at random, moving, out of focus or both.
TEST(ShearedFilter, of_random_planes_out_of_focus_is_what_lens_and_shutter_leave) {
    std::mt19937 random(22);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 16; ++i) {
        const double L = 6 + 18 * unit(random), v = i % 2 ? 6 * unit(random) : 0,
                     coc = (i % 4 < 2 ? 1 : -1) * (1 + 3 * unit(random)),
                     phase = 2 * pi_here * unit(random);
        BufferShape shape{48, 40, 4, std::uint64_t(i + 1)};
        shape.c1 = float(coc);
        const Samples samples =
            samples_of_scene(shape, [&, wave = grating(L, v, coc, phase)](
                                        double x, double y, double t, double u, double w) {
                SeenPoint seen = wave(x, y, t, u, w);
                seen.z = INFINITY;
                return seen;
            });
        const auto exact = [&](int x, int) { return grating_pixel(x, L, v, coc, phase); };
        const double filtered = rmse_of(sheared(samples), exact, 12, 10),
                     plain = rmse_of(box(samples), exact, 12, 10);
        EXPECT_LT(filtered, .025) << L << " " << v << " " << coc << ", plain " << plain;
        EXPECT_LT(filtered, plain) << L << " " << v << " " << coc;
    }
}

// Oracle: an edge that moves, one texture on either side and one speed.
double edge_pixel(int i, double at, double v) {
    const auto I = [](double s) { return s < 0 ? 0 : s < 1 ? s * s / 2 : s - .5; };
    return (I(at + v - i) - I(at - i)) / v;
}
TEST(ShearedFilter, of_a_moving_edge_is_its_ramp) {
    EXPECT_NEAR(edge_pixel(10, 10, 6), .916667, 1e-6);
    EXPECT_NEAR(edge_pixel(12, 10.25, 6), .625, 1e-6);
    for (const double at : {10., 10.25}) {
        const Samples samples =
            samples_of_scene({32, 16, 16}, [&](double x, double, double t, double, double) {
                return SeenPoint{x < at + 6 * t ? 1. : 0., 1, 6, 0};
            });
        const auto exact = [&](int x, int) { return edge_pixel(x, at, 6); };
        EXPECT_LT(rmse_of(sheared(samples), exact, 3), .02);
        EXPECT_LT(rmse_of(sheared(samples), exact, 3), rmse_of(box(samples), exact, 3));
    }
}

// Oracle: a moving disc over black; the share of the shutter at its middle line is a chord.
TEST(ShearedFilter, of_a_moving_disc_is_its_chord) {
    const Samples samples =
        samples_of_scene({48, 48, 16}, [](double x, double y, double t, double, double) {
            return SeenPoint{std::hypot(x - 10 - 28 * t, y - 24) < 9 ? 1. : 0., 1, 28, 0};
        });
    const Image out = sheared(samples);
    double mean = 0;
    for (int x = 20; x < 28; ++x) mean += double(*out.at(x, 24) + *out.at(x, 23)) / 16;
    EXPECT_NEAR(mean, .6428571, .02);
}

// Oracle: a plane that moves over one that stands still. Beyond two pixels of the swept edge
// nothing leaks.
TEST(ShearedFilter, of_two_planes_does_not_leak) {
    const double edge = 20, v = 4;
    for (int seed = 1; seed <= 4; ++seed) {
        const Samples samples = samples_of_scene(
            {48, 16, 8, std::uint64_t(seed)}, [&](double x, double, double t, double, double) {
                return x < edge + v * t ? SeenPoint{1, 1, v, 0} : SeenPoint{0, 2, 0, 0};
            });
        const Image out = sheared(samples), plain = box(samples);
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 48; ++x) {
                if (x + 1 < edge - 2) {
                    EXPECT_EQ(*out.at(x, y), 1.0f) << x;
                }
                if (x > edge + v + 2) {
                    EXPECT_EQ(*out.at(x, y), 0.0f) << x;
                }
            }
        const auto exact = [&](int x, int) { return edge_pixel(x, edge, v); };
        EXPECT_LE(rmse_of(out, exact), rmse_of(plain, exact));
        EXPECT_LT(rmse_of(out, exact), .06);
    }
}

TEST(ShearedFilter, keeps_a_constant_to_the_bit) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 12; ++i) {
        BufferShape shape{24, 24, 1 + i % 5, std::uint64_t(i)};
        if (i % 3) shape.c0 = float(5 * unit(random)), shape.c1 = float(5 * unit(random));
        const double vx = 10 * unit(random), vy = 10 * unit(random), value = std::abs(unit(random));
        const Samples samples =
            samples_of_scene(shape, [&](double x, double y, double, double, double) {
                return SeenPoint{value, x + y < 20 ? 1. : 2., vx, vy};
            });
        const Image out = sheared(samples);
        for (const float kept : out.pixels()) ASSERT_EQ(kept, float(value));
    }
}

// Random planes: speeds, ways, wavelengths, circles, samples and seeds; never above the box filter.
TEST(ShearedFilter, of_random_planes_is_never_worse_than_the_box) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 12; ++i) {
        const double L = 6 + 20 * unit(random), speed = 16 * unit(random),
                     angle = 2 * pi_here * unit(random);
        const double vx = speed * std::cos(angle), vy = speed * std::sin(angle);
        BufferShape shape{48, 48, 1 + int(8 * unit(random)), std::uint64_t(i)};
        if (i % 2) shape.c1 = float(4 * unit(random));
        const double coc = double(shape.c1);
        const Samples samples =
            samples_of_scene(shape, [&](double x, double, double t, double u, double) {
                return SeenPoint{.5 + .5 * std::sin(2 * pi_here * (x - vx * t - coc * u) / L),
                                 INFINITY, vx, vy};
            });
        const auto exact = [&](int x, int) { return grating_pixel(x, L, vx, coc); };
        EXPECT_LE(rmse_of(sheared(samples), exact, 18), rmse_of(box(samples), exact, 18) + 1e-9)
            << "speed " << vx << ", " << vy << ", L " << L << ", coc " << coc << ", spp "
            << shape.spp;
    }
}

Image splat(const Samples& samples) {
    return RunNode("trajectory-splat").in("samples", samples).out<Image>("image");
}

TEST(TrajectorySplat, of_a_moving_texture_is_what_was_measured) {
    struct {
        Wave wave;
        double one, four;
    } const table[] = {{waves[0], .13, .04}, {waves[1], .09, .03}, {waves[2], .19, .065}};
    for (const auto& row : table)
        for (const int spp : {1, 4}) {
            double filtered = 0, plain = 0;
            for (std::uint64_t seed = 1; seed <= 4; ++seed) {
                const Samples samples =
                    samples_of_scene({96, 16, spp, seed}, grating(row.wave.L, row.wave.v));
                const auto exact = [&](int x, int) {
                    return grating_pixel(x, row.wave.L, row.wave.v);
                };
                filtered += std::pow(rmse_of(splat(samples), exact, 25), 2) / 4;
                plain += std::pow(rmse_of(box(samples), exact, 25), 2) / 4;
            }
            EXPECT_LT(std::sqrt(filtered), spp == 1 ? row.one : row.four)
                << row.wave.L << ", plain " << std::sqrt(plain);
            EXPECT_LT(filtered, .4 * plain);
        }
}

TEST(TrajectorySplat, keeps_a_constant_and_follows_planes_that_come_nearer) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 20; ++i) {
        Samples samples = samples_of_scene(
            {24, 20, 2, std::uint64_t(i)}, [&](double, double, double, double, double) {
                return SeenPoint{.7, 2, 9 * unit(random), 9 * unit(random)};
            });
        // Some come nearer, some pass the camera.
        std::vector<float> motion(samples.motion().begin(), samples.motion().end());
        for (size_t k = 2; k < motion.size(); k += 3) motion[k] = float(3 * unit(random));
        samples.add("motion", 3, std::move(motion));
        const Image out = splat(samples);
        for (const float kept : out.pixels()) ASSERT_TRUE(kept == .7f || kept == 0);
    }
    // A still picture is the box filter's.
    const Samples still = samples_of_scene({16, 16, 4, 1, 0, 0, false}, grating(8, 0));
    const Image out = splat(still), plain = box(still);
    for (size_t i = 0; i < out.pixels().size(); ++i)
        EXPECT_NEAR(out.pixels()[i], plain.pixels()[i], 1e-6);
}

// One sample alone: its light lies along its path, by the time spent in each pixel.
TEST(TrajectorySplat, gives_each_pixel_the_time_spent_in_it) {
    Samples one;
    one.width = 16, one.height = 8;
    one.set_size(2);
    std::vector<std::uint64_t> first(129, 1);
    first[0] = 0, first[128] = 2;
    for (size_t pixel = 1; pixel < 128; ++pixel) first[pixel] = 1;
    one.first = std::move(first);
    one.add("xy", 2, {.5f, .5f, 15.5f, 7.5f});
    one.add("t", 1, {0, 0});
    one.add("z", 1, {1, 1});
    one.add("motion", 3, {12, 6, 0, 0, 0, 0});
    one.add("rgb", 3, {1, 1, 1, 0, 0, 0});
    const Image out = splat(one);
    int lit = 0;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x) {
            lit += *out.at(x, y) > 0;
            if (*out.at(x, y) > 0) {
                EXPECT_LE(std::abs((x + .5) / 2 - (y + .25)), 1.0);
            }
        }
    EXPECT_GE(lit, 18);
}

Image layered(const Samples& samples, double gain = 2) {
    return RunNode("slope-layers").in("samples", samples).set("gain", gain).out<Image>("image");
}

// A plane that moves over one that stands still: where one filter for both must be narrow.
TEST(SlopeLayers, of_two_planes_follow_both) {
    for (const double v : {12., 24.}) {
        double filtered = 0, one = 0, plain = 0;
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            const double edge = 20;
            const Samples samples = samples_of_scene(
                {72, 24, 4, seed}, [&](double x, double, double t, double, double) {
                    return x < edge + v * t ? SeenPoint{1, 1, v, 0} : SeenPoint{0, 2, 0, 0};
                });
            const auto exact = [&](int x, int) { return edge_pixel(x, edge, v); };
            filtered += std::pow(rmse_of(layered(samples, 1), exact, 8), 2) / 3;
            one += std::pow(rmse_of(sheared(samples), exact, 8), 2) / 3;
            plain += std::pow(rmse_of(box(samples), exact, 8), 2) / 3;
            const Image out = layered(samples, 1);
            for (int y = 0; y < 24; ++y)
                for (int x = 0; x < 72; ++x) {
                    if (x + 1 < edge - 2) {
                        ASSERT_NEAR(*out.at(x, y), 1, 1e-6) << x;
                    }
                    if (x > edge + v + 2) {
                        ASSERT_NEAR(*out.at(x, y), 0, 1e-6) << x;
                    }
                }
        }
        EXPECT_LT(filtered, .6 * plain) << v;
        EXPECT_LT(filtered, one) << v;
    }
}

TEST(SlopeLayers, keep_a_constant_to_the_bit_and_a_texture_as_one_layer_does) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 6; ++i) {
        BufferShape shape{24, 24, 1 + i % 4, std::uint64_t(i)};
        if (i % 2) shape.c1 = float(4 * unit(random));
        const double vx = 10 * unit(random), vy = 10 * unit(random), value = std::abs(unit(random));
        const Samples samples =
            samples_of_scene(shape, [&](double x, double, double, double, double) {
                return x < 12 ? SeenPoint{value, 1, vx, vy} : SeenPoint{value, INFINITY, 0, 0};
            });
        const Image out = layered(samples);
        for (const float kept : out.pixels()) ASSERT_EQ(kept, float(value));
    }
    const Samples samples = samples_of_scene({96, 8, 4, 3}, grating(8, 6));
    const auto exact = [](int x, int) { return grating_pixel(x, 8, 6); };
    EXPECT_LT(rmse_of(layered(samples), exact, 25), .035);
}

TEST(ShearedFilter, works_without_motion_and_lens_and_says_what_does_not_fit) {
    Samples still = samples_of_scene({8, 8, 4, 1, 0, 0, false}, grating(8, 0));
    const Image out = sheared(still), plain = box(still);
    for (size_t i = 0; i < out.pixels().size(); ++i)
        EXPECT_NEAR(out.pixels()[i], plain.pixels()[i], 1e-6);
    const Samples other = samples_of_scene({9, 8, 1}, grating(8, 0));
    EXPECT_NE(error_of([&] {
                  RunNode("sheared-filter")
                      .in("samples", other)
                      .in("slopes", slopes_of(still))
                      .out<Image>("image");
              }).find("'slopes' is 8 x 8, the samples 9 x 8"),
              std::string::npos);
}

}  // namespace
}  // namespace weft
