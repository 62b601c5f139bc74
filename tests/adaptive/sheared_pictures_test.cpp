// Pictures of what sheared filters assume.
#include "adaptive/light_field_spectrum.h"
#include "tests/adaptive/plane_samples.h"

namespace weft {
namespace {

// A wave that moves by v has one frequency, on the line Omega_t = -v Omega_x.
TEST(LightFieldSpectrum, of_a_moving_wave_lies_on_its_line) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 8; ++i) {
        const double f = .08 + .2 * unit(random), v = 30 * unit(random) - 15;
        std::vector<adaptive::WindowPoint> points;
        for (int k = 0; k < 40000; ++k) {
            const double x = 64 * unit(random), t = unit(random);
            points.push_back({x, t, .5 + .4 * std::sin(2 * pi_here * f * (x - v * t))});
        }
        const adaptive::LightFieldWindow window =
            adaptive::light_field_window(points, 128, 64, 48, 1);
        constexpr int size = 129;
        const std::vector<double> found = adaptive::amplitudes(window, size, .5, 8);
        // Half of the plane: the other one is its mirror.
        size_t best = 0;
        for (size_t p = 0; p < found.size(); ++p)
            if (p % size > size / 2 && found[p] > found[best]) best = p;
        const double x = (double(best % size) / (size - 1) - .5),
                     y = 8 * (1 - 2 * double(best / size) / (size - 1));
        EXPECT_NEAR(x, f, .01);
        EXPECT_NEAR(y, -v * f, .3) << f << " " << v;
        // Real values: F(-X, -Y) is F(X, Y)'s conjugate.
        for (size_t p = 0; p < found.size(); p += 97)
            EXPECT_NEAR(found[p], found[found.size() - 1 - p], 1e-9 * found[best]);
    }
}

TEST(LightFieldSpectrum, of_a_constant_and_of_nothing_is_nothing) {
    std::vector<adaptive::WindowPoint> points;
    for (int k = 0; k < 100; ++k) points.push_back({k * .1, k * .01, .7});
    for (const auto& some : {points, std::vector<adaptive::WindowPoint>{}})
        for (const double a :
             adaptive::amplitudes(adaptive::light_field_window(some, 16, 8, 8, 1), 9, .5, 4))
            EXPECT_NEAR(a, 0, 1e-12);
}

Image slopes_of(const Samples& samples) {
    return RunNode("slope-bounds").in("samples", samples).out<Image>("slopes");
}

TEST(ShowSlopes, are_yellow_where_all_moves_alike_and_red_where_it_does_not) {
    const Samples alike = samples_of_scene({16, 16, 4}, grating(8, 8)),
                  mixed =
                      samples_of_scene({16, 16, 4}, [](double x, double, double, double, double) {
                          return SeenPoint{0, 1, std::fmod(x, 1) < .5 ? 8. : 0., 0};
                      });
    const auto shown = [](const Samples& samples) {
        return RunNode("show-slopes").in("slopes", slopes_of(samples)).out<Image>("image");
    };
    const Image a = shown(alike), m = shown(mixed);
    EXPECT_NEAR(a.at(8, 8)[0], .5, 1e-5);
    EXPECT_NEAR(a.at(8, 8)[1], .5, 1e-5);
    EXPECT_NEAR(m.at(8, 8)[0], .5, 1e-5);
    EXPECT_EQ(m.at(8, 8)[1], 0);
    EXPECT_EQ(m.at(8, 8)[2], 0);
    const Image none = RunNode("show-slopes")
                           .in("slopes", RunNode("slope-bounds")
                                             .in("samples", alike)
                                             .set("min-samples", 1000000)
                                             .out<Image>("slopes"))
                           .out<Image>("image");
    EXPECT_GT(none.at(8, 8)[2], 0);
    EXPECT_EQ(none.at(8, 8)[0], 0);
}

TEST(ShowFootprints, lie_along_the_way_of_motion) {
    const Samples samples = samples_of_scene({48, 16, 4}, grating(8, 12));
    const Image out = RunNode("show-footprints")
                          .in("samples", samples)
                          .in("slopes", slopes_of(samples))
                          .set("step", 48)
                          .out<Image>("image");
    // The pixel is (24, 24): outside. Of a grid of 16 it is (24, 8).
    for (const float v : out.pixels()) EXPECT_EQ(v, 0);
    const Image some = RunNode("show-footprints")
                           .in("samples", samples)
                           .in("slopes", slopes_of(samples))
                           .set("step", 16)
                           .out<Image>("image");
    EXPECT_EQ(some.at(24, 8)[0], 1);  // the pixel itself
    int wide = 0;
    for (int x = 0; x < 48; ++x) wide += some.at(x, 8)[1] > 0;
    EXPECT_GT(wide, 24);
    for (int x = 0; x < 48; ++x) {
        EXPECT_EQ(some.at(x, 5)[1], 0);
        EXPECT_EQ(some.at(x, 11)[1], 0);
    }
}

TEST(ShowSpectrum, runs_over_either_axis_and_says_what_it_lacks) {
    BufferShape shape{40, 24, 16};
    shape.c1 = 3;
    const Samples samples = samples_of_scene(shape, grating(8, 6, 3));
    const auto run = [](const Samples& of, const Image& slopes, const char* axis,
                        const char* over) {
        return RunNode("show-spectrum")
            .in("samples", of)
            .in("slopes", slopes)
            .set("axis", axis)
            .set("over", over)
            .set("size", 64)
            .out<Image>("spectrum");
    };
    for (const char* axis : {"x", "y"})
        for (const char* over : {"time", "lens"}) {
            const Image out = run(samples, slopes_of(samples), axis, over);
            float most = 0;
            for (const float v : out.pixels()) {
                ASSERT_TRUE(std::isfinite(v));
                most = std::max(most, v);
            }
            EXPECT_GT(most, .5f);
        }
    shape.c1 = 0, shape.moving = false;
    const Samples still = samples_of_scene(shape, grating(8, 0));
    EXPECT_NE(error_of([&] {
                  run(still, slopes_of(still), "x", "time");
              }).find("'show-spectrum' needs t"),
              std::string::npos);
    EXPECT_NE(error_of([&] {
                  run(still, slopes_of(still), "x", "lens");
              }).find("'show-spectrum' needs uv"),
              std::string::npos);
}

// Numbers that are none, anywhere in a buffer: pictures of the rest, or an error that is one.
TEST(ShearedNodes, bear_garbage_in_any_channel) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(0, 1);
    const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 0, -1};
    for (int round = 0; round < 12; ++round) {
        BufferShape shape{24, 20, 1 + round % 4, std::uint64_t(round)};
        if (round % 3) shape.c0 = float(8 * unit(random) - 4), shape.c1 = float(4 * unit(random));
        Samples samples = samples_of_scene(shape, grating(8, 6, 2));
        for (const char* name : {"uv", "t", "z", "motion", "rgb"}) {
            const Channel* channel = samples.find(name);
            if (!channel) continue;
            std::vector<float> values(channel->values.view().begin(), channel->values.view().end());
            for (float& v : values)
                if (unit(random) < .05) v = bad[random() % std::size(bad)];
            samples.add(name, channel->components, std::move(values));
        }
        const auto finite = [&](const char* who, const Image& image) {
            for (const float v : image.pixels()) ASSERT_TRUE(std::isfinite(v)) << who << round;
        };
        for (const char* effect : {"motion", "lens", "both"}) {
            const Image slopes = RunNode("slope-bounds")
                                     .in("samples", samples)
                                     .set("effect", effect)
                                     .out<Image>("slopes");
            for (const char* type : {"sheared-filter", "factored-sheared", "several-axis-aligned",
                                     "show-footprints"}) {
                RunNode node(type);
                node.in("samples", samples).in("slopes", slopes);
                if (type == std::string_view("factored-sheared")) node.set("order", "any");
                try {
                    finite(type, node.out<Image>("image"));
                } catch (const Error& error) {
                    EXPECT_FALSE(std::string(error.what()).empty());
                }
            }
            const Image counts =
                RunNode("sampling-density").in("slopes", slopes).out<Image>("counts");
            finite("sampling-density", counts);
        }
        for (const char* type : {"trajectory-splat", "slope-layers"})
            finite(type, RunNode(type).in("samples", samples).out<Image>("image"));
    }
}

}  // namespace
}  // namespace weft
