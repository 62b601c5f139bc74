// Slopes of a picture's light field, the samples that they ask for, and widths of filters.
#include "adaptive/slopes.h"

#include "tests/adaptive/plane_samples.h"

namespace weft {
namespace {

Image slopes_of(const Samples& samples, const char* effect = "motion") {
    return RunNode("slope-bounds")
        .in("samples", samples)
        .set("effect", effect)
        .out<Image>("slopes");
}
Image motion_slopes(double lo, double hi) {
    Image slopes(1, 1, {"s-lo", "s-hi", "n.x", "n.y", "across-lo", "across-hi", "count"});
    float* s = slopes.at(0, 0);
    s[0] = float(lo), s[1] = float(hi), s[2] = 1, s[6] = 9;
    return slopes;
}
Image lens_slopes(double lo, double hi) {
    Image slopes(1, 1, {"lens-lo", "lens-hi", "count"});
    float* s = slopes.at(0, 0);
    s[0] = float(lo), s[1] = float(hi), s[2] = 9;
    return slopes;
}
double samples_before(const Image& slopes, const char* mode = "sheared") {
    return double(RunNode("sampling-density")
                      .in("slopes", slopes)
                      .set("mode", mode)
                      .out<Image>("band")
                      .at(0, 0)[3]);
}

TEST(SlopeBounds, of_a_still_scene_are_zero_and_ask_for_the_oversampling_alone) {
    const Samples still = samples_of_scene({16, 16, 2}, grating(8, 0));
    const Image slopes = slopes_of(still, "both");
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x)
            for (const char* channel :
                 {"s-lo", "s-hi", "across-lo", "across-hi", "lens-lo", "lens-hi"})
                EXPECT_EQ(slopes.at(x, y)[slopes.find(channel)], 0.0f);
    for (const float oversample : {4.0f, 7.0f}) {
        const Image counts = RunNode("sampling-density")
                                 .in("slopes", slopes)
                                 .set("oversample", double(oversample))
                                 .out<Image>("counts");
        for (const float c : counts.pixels()) EXPECT_EQ(c, oversample);
    }
}

// A plane that crosses a still background: 8 px to the right, 6 wide.
SeenScene passing_bar(double start, double v) {
    return [=](double x, double, double t, double, double) {
        const double at = start + v * t;
        return x >= at && x < at + 6 ? SeenPoint{1, 1, v, 0} : SeenPoint{0, 2, 0, 0};
    };
}

TEST(SlopeBounds, know_of_what_passes_where_no_sample_of_it_landed) {
    // The whole picture moves by 8: exactly that, everywhere.
    const Image whole = slopes_of(samples_of_scene({48, 8, 1}, grating(16, 8)));
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 48; ++x) {
            EXPECT_NEAR(whole.at(x, y)[0], -8, 1e-4);
            EXPECT_NEAR(whole.at(x, y)[1], -8, 1e-4);
            EXPECT_NEAR(whole.at(x, y)[2], 1, 1e-6);
        }
    // A bar that passes over what stands still: both are known wherever the bar gets to.
    const Samples samples = samples_of_scene({64, 8, 1}, passing_bar(12, 30));
    const Image slopes = slopes_of(samples);
    int unseen = 0;
    for (int y = 0; y < 8; ++y)
        for (int x = 13; x < 47; ++x) {
            const float* s = slopes.at(x, y);
            EXPECT_NEAR(s[0], -30, 1e-3) << x;
            bool landed = false;
            const auto range = samples.of_pixel(size_t(y) * 64 + size_t(x));
            for (size_t i = range.begin; i < range.end; ++i) landed |= samples.rgb()[3 * i] > 0;
            unseen += !landed;
        }
    EXPECT_GT(unseen, 100);
    EXPECT_EQ(slopes.at(2, 4)[0], 0.0f);
    EXPECT_EQ(slopes.at(60, 4)[0], 0.0f);
}

TEST(SlopeBounds, random_planes_and_ways) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 20; ++i) {
        const double vx = 20 * unit(random), vy = 20 * unit(random), speed = std::hypot(vx, vy);
        const Samples samples = samples_of_scene({24, 24, 1, std::uint64_t(i)},
                                                 [&](double, double, double, double, double) {
                                                     return SeenPoint{0.5, 3, vx, vy};
                                                 });
        const Image slopes = slopes_of(samples);
        for (int at : {0, 12, 23}) {
            const float* s = slopes.at(at, at);
            EXPECT_NEAR(s[0], -speed, 1e-3);
            EXPECT_NEAR(s[1], -speed, 1e-3);
            EXPECT_NEAR(s[2] * speed, vx, 1e-3);
            EXPECT_NEAR(s[3] * speed, vy, 1e-3);
            EXPECT_NEAR(s[4], 0, 1e-3);
            EXPECT_NEAR(s[5], 0, 1e-3);
        }
    }
}

TEST(SlopeBounds, of_a_lens_are_circles_of_confusion) {
    BufferShape shape{24, 24, 2};
    shape.c0 = -8, shape.c1 = 4, shape.moving = false;
    const Image near = slopes_of(samples_of_scene(shape, grating(8, 0, -4)), "lens");
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 24; ++x) {
            EXPECT_NEAR(near.at(x, y)[0], 4, 1e-5);  // coc = -8 / 1 + 4, s = -coc
            EXPECT_NEAR(near.at(x, y)[1], 4, 1e-5);
        }
    // The far half of a picture blurs over the near half, as far as its circle reaches.
    const Image both = slopes_of(samples_of_scene(shape,
                                                  [](double x, double, double, double, double) {
                                                      return SeenPoint{0, x < 16 ? 2.0 : 1.0, 0, 0};
                                                  }),
                                 "lens");
    EXPECT_NEAR(both.at(0, 12)[1], 0, 1e-6);
    EXPECT_NEAR(both.at(14, 12)[1], 4, 1e-6);
    EXPECT_NEAR(both.at(14, 12)[0], 0, 1e-6);
}

TEST(SlopeBounds, need_places_and_depths) {
    Samples bare;
    bare.width = bare.height = bare.spp = 1;
    bare.set_size(1);
    bare.add("xy", 2, {0.5f, 0.5f});
    EXPECT_NE(error_of([&] { slopes_of(bare); }).find("needs z"), std::string::npos);
    const Image other(2, 2, 3);
    EXPECT_NE(error_of([&] {
                  RunNode("sampling-density").in("slopes", other).out<Image>("counts");
              }).find("slope-bounds makes"),
              std::string::npos);
}

TEST(SamplingDensity, is_that_worked_out_by_hand) {
    struct {
        double a, b, n;
    } const table[] = {{0, 0, 1}, {2, 2, 1},  {8, 8, .25}, {6, 10, .33333333},
                       {0, 8, 4}, {-4, 4, 4}, {20, 40, .1}};
    for (const auto& row : table) {
        EXPECT_NEAR(samples_before(motion_slopes(row.a, row.b)), row.n, 1e-6)
            << row.a << " " << row.b;
        EXPECT_NEAR(samples_before(motion_slopes(-row.b, -row.a)), row.n, 1e-6);
    }
    EXPECT_NEAR(samples_before(lens_slopes(0, 0)), 1, 1e-6);
    EXPECT_NEAR(samples_before(lens_slopes(4, 4)), std::pow(2 * .61 / 4, 2), 1e-6);
    EXPECT_NEAR(samples_before(motion_slopes(0, 0), "axis-aligned"), 1, 1e-6);
    // Axis-aligned needs more than sheared, as soon as something moves one way.
    for (const auto& row : table) {
        if (row.b <= 2 || row.a < 0) continue;
        EXPECT_GT(samples_before(motion_slopes(row.a, row.b), "axis-aligned"), row.n);
    }
}

TEST(SamplingDensity, makes_fractions_whole_by_chance_without_bias) {
    Image slopes(100, 100, {"s-lo", "s-hi", "n.x", "n.y", "across-lo", "across-hi", "count"});
    for (int y = 0; y < 100; ++y)
        for (int x = 0; x < 100; ++x) {
            float* s = slopes.at(x, y);
            s[0] = 6, s[1] = 10, s[2] = 1, s[6] = 9;
        }
    const Image counts = RunNode("sampling-density").in("slopes", slopes).out<Image>("counts");
    double sum = 0;
    for (const float c : counts.pixels()) {
        EXPECT_TRUE(c == 1 || c == 2);
        sum += double(c);
    }
    EXPECT_NEAR(sum / 1e4, 4.0 / 3, 0.02);
    const Image more =
        RunNode("sampling-density").in("slopes", slopes).set("have", 1).out<Image>("more");
    EXPECT_EQ(*std::max_element(more.pixels().begin(), more.pixels().end()), 1.0f);
    EXPECT_EQ(*std::min_element(more.pixels().begin(), more.pixels().end()), 0.0f);
}

TEST(BlurWidth, takes_six_per_cent_of_what_motion_leaves) {
    // Wavelength 16, speed 8: the picture is a grating of less amplitude; filtered, of 6 % less.
    constexpr int n = 96;
    Image image(n, 4, 1),
        slopes(n, 4, {"s-lo", "s-hi", "n.x", "n.y", "across-lo", "across-hi", "count"});
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < n; ++x) {
            *image.at(x, y) = float(grating_pixel(x, 16, 8));
            float* s = slopes.at(x, y);
            s[0] = s[1] = -8, s[2] = 1, s[6] = 9;
        }
    const Image width = RunNode("blur-width").in("slopes", slopes).out<Image>("width");
    EXPECT_NEAR(width.at(5, 2)[0], 8.0 / 9 * std::sqrt(6.0), 1e-5);
    const Image out =
        RunNode("axis-aligned-filter").in("image", image).in("width", width).out<Image>("image");
    double kept = 0, whole = 0;
    for (int x = 16; x < n - 16; ++x) {
        const double wave = std::sin(2 * pi_here * (x + .5 - 4) / 16);
        kept += wave * (double(*out.at(x, 2)) - .5), whole += wave * (double(*image.at(x, 2)) - .5);
    }
    EXPECT_NEAR(kept / whole, 0.94, 0.015);
    // Nothing is blurred where something stands still.
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < 4; ++y) slopes.at(x, y)[1] = 0;
    EXPECT_EQ(*RunNode("blur-width").in("slopes", slopes).out<Image>("width").at(3, 3), 0.0f);
}

TEST(BlurWidth, filters_along_any_way_and_not_across) {
    constexpr int n = 64;
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 10; ++i) {
        const double angle = 2 * pi_here * unit(random), c = std::cos(angle), s = std::sin(angle);
        Image image(n, n, 1), width(n, n, {"beta", "n.x", "n.y"});
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                *image.at(x, y) = float(x * -s + y * c);  // constant along the way
                float* w = width.at(x, y);
                w[0] = 8, w[1] = float(c), w[2] = float(s);
            }
        const Image out = RunNode("axis-aligned-filter")
                              .in("image", image)
                              .in("width", width)
                              .out<Image>("image");
        for (int y = 10; y < n - 10; ++y)
            for (int x = 10; x < n - 10; ++x) ASSERT_NEAR(*out.at(x, y), *image.at(x, y), 1e-4);
    }
}

}  // namespace
}  // namespace weft
