// Motion blur and defocus by several axis-aligned filters against pictures that are known exactly.
#include <algorithm>

#include "tests/adaptive/plane_samples.h"

namespace weft {
namespace {

Image filtered(const Samples& samples, int bands = 3, const char* effect = "motion") {
    const Image slopes =
        RunNode("slope-bounds").in("samples", samples).set("effect", effect).out<Image>("slopes");
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

BufferShape through_lens(int width, int height, int spp, std::uint64_t seed, double coc) {
    return {width, height, spp, seed, 0, float(coc)};
}

// Oracle 2: the same through a lens, in focus before the plane and behind it.
TEST(SeveralAxisAligned, of_a_plane_out_of_focus_is_better_than_its_samples) {
    struct {
        double L, coc;
    } const waves[] = {{8, 2}, {8, -3}, {16, 4}, {24, 6}};
    for (const auto& w : waves) {
        double several = 0, plain = 0;
        for (std::uint64_t seed = 1; seed <= 2; ++seed) {
            const Samples samples =
                samples_of_scene(through_lens(96, 64, 4, seed, w.coc), grating(w.L, 0, w.coc));
            const auto exact = [&](int x, int) { return grating_pixel(x, w.L, 0, w.coc); };
            several += std::pow(rmse_of(filtered(samples, 3, "lens"), exact, 28, 28), 2) / 2;
            plain += std::pow(rmse_of(box(samples), exact, 28, 28), 2) / 2;
        }
        EXPECT_LT(several, .25 * plain)
            << w.L << " " << w.coc << ": " << std::sqrt(several) << ", " << std::sqrt(plain);
    }
}

TEST(SeveralAxisAligned, of_many_samples_out_of_focus_is_near_the_picture) {
    for (const double L : {10., 30.}) {
        const Samples samples = samples_of_scene(through_lens(60, 44, 64, 1, 4), grating(L, 0, 4));
        const auto exact = [&](int x, int) { return grating_pixel(x, L, 0, 4); };
        EXPECT_LT(rmse_of(filtered(samples, 1, "lens"), exact, 20, 20), .07) << L;
        EXPECT_LT(rmse_of(filtered(samples, 3, "lens"), exact, 20, 20), .01) << L;
    }
}

// Half as wide as it is high, and with three blades: never worse than the samples' own means.
TEST(SeveralAxisAligned, of_lenses_of_other_shapes_follows_their_outline) {
    for (const int blades : {0, 3}) {
        const auto scene = [&](double x, double, double, double u, double) {
            return SeenPoint{.5 + .5 * std::sin(2 * pi_here * (x - 5 * .5 * u) / 16), 1};
        };
        const auto with_lens = [&](int spp) {
            Samples samples = samples_of_scene(through_lens(60, 44, spp, 1, 5), scene);
            samples.lens->aspect = .5f, samples.lens->blades = blades;
            if (blades == 0) return samples;
            // Over the polygon, whose points are the disc's by way of the square.
            const SeenScene polygon = scene;
            std::vector<float> uv(2 * samples.size()), rgb(3 * samples.size());
            size_t i = 0;
            for (int y = 0; y < samples.height; ++y)
                for (int x = 0; x < samples.width; ++x) {
                    const SampleSequence numbers = sample_sequence(Sampler::sobol, 1, x, y, spp);
                    for (int s = 0; s < spp; ++s, ++i) {
                        const Disk on = numbers(std::uint32_t(s), 1);
                        const auto place = on_lens(on.u, on.v, *samples.lens);
                        uv[2 * i] = place[0], uv[2 * i + 1] = place[1];
                        const SeenPoint seen = polygon(double(samples.xy()[2 * i]), 0, 0,
                                                       double(place[0]), double(place[1]));
                        for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = float(seen.value);
                    }
                }
            std::erase_if(samples.channels, [](const Channel& channel) {
                return channel.name == "uv" || channel.name == "rgb";
            });
            samples.add("uv", 2, std::move(uv));
            samples.add("rgb", 3, std::move(rgb));
            return samples;
        };
        const Samples few = with_lens(4);
        const Image reference = box(with_lens(1024));
        const auto exact = [&](int x, int y) { return double(*reference.at(x, y)); };
        const double several = rmse_of(filtered(few, 3, "lens"), exact, 20, 20),
                     plain = rmse_of(box(few), exact, 20, 20);
        EXPECT_LT(several, .4 * plain) << blades << " blades: " << several << ", " << plain;
    }
}

// Both at once: filtered along either, what the other blurs stays blurred as much.
TEST(SeveralAxisAligned, of_motion_out_of_focus_is_better_than_its_samples) {
    struct {
        double v, coc;
    } const both[] = {{8, 2}, {3, 5}, {12, 4}};
    for (const auto& w : both) {
        const Samples samples =
            samples_of_scene(through_lens(120, 56, 4, 5, w.coc), grating(24, w.v, w.coc));
        const auto exact = [&](int x, int) { return grating_pixel(x, 24, w.v, w.coc); };
        const double several = rmse_of(filtered(samples, 3, "both"), exact, 40, 25),
                     plain = rmse_of(box(samples), exact, 40, 25);
        EXPECT_LT(several, .7 * plain) << w.v << " " << w.coc;
    }
}

TEST(SeveralAxisAligned, keeps_constants_out_of_focus_to_the_bit) {
    for (int i = 0; i < 4; ++i) {
        const float value = .1f + .17f * float(i);
        const Samples samples =
            samples_of_scene(through_lens(24, 20, 1 + i, std::uint64_t(i), 1.5 * i - 2),
                             [&](double, double, double, double, double) {
                                 return SeenPoint{double(value), 1};
                             });
        const Image out = filtered(samples, 3, "both");
        for (const float kept : out.pixels()) ASSERT_EQ(kept, value);
    }
}

TEST(SeveralAxisAligned, says_what_it_needs) {
    const Samples samples = samples_of_scene({8, 8, 4}, grating(8, 1));
    const Image lens =
        RunNode("slope-bounds").in("samples", samples).set("effect", "motion").out<Image>("slopes");
    Samples still = samples;
    std::erase_if(still.channels, [](const Channel& c) { return c.name == "motion"; });
    RunNode node("several-axis-aligned");
    const Image picture = node.in("samples", still).in("slopes", lens).out<Image>("image");
    ASSERT_EQ(node.ctx.warnings.size(), 1u);
    EXPECT_NE(node.ctx.warnings[0].find("neither motion nor a lens"), std::string::npos);
    EXPECT_TRUE(std::ranges::equal(picture.pixels(), box(still).pixels()));
    const Image other = RunNode("slope-bounds")
                            .in("samples", samples_of_scene({9, 8, 4}, grating(8, 1)))
                            .set("effect", "motion")
                            .out<Image>("slopes");
    EXPECT_NE(error_of([&] {
                  RunNode("several-axis-aligned")
                      .in("samples", samples)
                      .in("slopes", other)
                      .out<Image>("image");
              }).find("expected one size"),
              std::string::npos);
}

}  // namespace
}  // namespace weft
