// Motion blur by several axis-aligned filters against pictures that are known exactly.
#include "tests/adaptive/plane_samples.h"

namespace weft {
namespace {

Image filtered(const Samples& samples, int bands = 3) {
    const Image slopes =
        RunNode("slope-bounds").in("samples", samples).set("effect", "motion").out<Image>("slopes");
    return RunNode("several-axis-aligned")
        .in("samples", samples)
        .in("slopes", slopes)
        .set("bands", bands)
        .out<Image>("image");
}
Image box(const Samples& samples) {
    return RunNode("pixel-filter").in("samples", samples).out<Image>("image");
}

// Oracle 1: what is left of a moving texture, from four samples a pixel.
TEST(SeveralAxisAligned, of_a_moving_texture_is_better_than_its_samples) {
    struct {
        double L, v;
    } const waves[] = {{8, 6}, {16, 24}, {16, 8}, {32, 12}};
    for (const auto& w : waves) {
        double several = 0, plain = 0;
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            const Samples samples = samples_of_scene({160, 8, 4, seed}, grating(w.L, w.v));
            const auto exact = [&](int x, int) { return grating_pixel(x, w.L, w.v); };
            several += std::pow(rmse_of(filtered(samples), exact, 60), 2) / 4;
            plain += std::pow(rmse_of(box(samples), exact, 60), 2) / 4;
        }
        EXPECT_LT(several, .5 * plain)
            << w.L << " " << w.v << ": " << std::sqrt(several) << ", " << std::sqrt(plain);
    }
}

// Any number of bands, any way: of many samples, the picture within a few per cent of its swing.
TEST(SeveralAxisAligned, of_many_samples_is_near_the_picture) {
    for (const double L : {16., 24., 48.}) {
        const Samples samples = samples_of_scene({160, 1, 256}, grating(L, 8));
        const auto exact = [&](int x, int) { return grating_pixel(x, L, 8); };
        double before = 1;
        for (const int bands : {2, 4, 8}) {
            const double error = rmse_of(filtered(samples, bands), exact, 70);
            EXPECT_LT(error, .05) << L << " " << bands;
            EXPECT_LT(error, 1.1 * before) << "more bands are nearer";
            before = error;
        }
    }
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 4; ++i) {
        const double angle = 2 * pi_here * unit(random), c = std::cos(angle), s = std::sin(angle),
                     speed = 6 + 6 * unit(random);
        const Samples samples = samples_of_scene(
            {96, 96, 4, std::uint64_t(i)}, [&](double x, double y, double t, double, double) {
                return SeenPoint{.5 + .5 * std::sin(2 * pi_here * (x * c + y * s - speed * t) / 24),
                                 1, speed * c, speed * s};
            });
        const auto exact = [&](int x, int y) {
            return .5 + .5 * sinc(speed / 24) * sinc(c / 24) * sinc(s / 24) *
                            std::sin(2 * pi_here * ((x + .5) * c + (y + .5) * s - speed / 2) / 24);
        };
        EXPECT_LT(rmse_of(filtered(samples), exact, 40, 40), rmse_of(box(samples), exact, 40, 40))
            << angle << " " << speed;
    }
}

TEST(SeveralAxisAligned, keeps_constants_to_the_bit_and_still_pictures_as_they_are) {
    for (int i = 0; i < 6; ++i) {
        const float value = .1f + .17f * float(i);
        const Samples samples = samples_of_scene(
            {32, 24, 2 + i, std::uint64_t(i)}, [&](double, double, double, double, double) {
                return SeenPoint{double(value), 1, 3. * i, 9. - i};
            });
        const Image out = filtered(samples);
        for (const float kept : out.pixels()) ASSERT_EQ(kept, value);
    }
    for (const bool moving : {false, true}) {
        const Samples still = samples_of_scene({16, 16, 4, 1, 0, 0, moving}, grating(8, 0));
        const Image out = filtered(still), plain = box(still);
        for (size_t i = 0; i < out.pixels().size(); ++i)
            ASSERT_NEAR(out.pixels()[i], plain.pixels()[i], 1e-6);
    }
}

TEST(SeveralAxisAligned, says_what_it_needs) {
    BufferShape shape{8, 8, 4};
    shape.c1 = 3;
    const Samples samples = samples_of_scene(shape, grating(8, 1, 3));
    const Image lens =
        RunNode("slope-bounds").in("samples", samples).set("effect", "lens").out<Image>("slopes");
    EXPECT_NE(error_of([&] {
                  RunNode("several-axis-aligned")
                      .in("samples", samples)
                      .in("slopes", lens)
                      .out<Image>("image");
              }).find("the slopes hold no motion"),
              std::string::npos);
}

}  // namespace
}  // namespace weft
