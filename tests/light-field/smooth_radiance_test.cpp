// smooth-radiance takes noise away and leaves alone what is not noise.
#include "light-field/smooth_radiance_kernel.h"
#include "light-field/build_hierarchy_kernel.h"
#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {

// One plane in focus; radiance(x, y, random number).
template <class Radiance>
Samples plane(int width, int height, int spp, Radiance&& radiance) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> unit(0, 1);
    Samples s;
    s.width = width;
    s.height = height;
    s.spp = spp;
    std::vector<float> xy, z, rgb;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int i = 0; i < spp; ++i) {
                const float px = float(x) + unit(random), py = float(y) + unit(random);
                xy.insert(xy.end(), {px, py});
                z.push_back(5);
                const float value = radiance(px, py, unit(random));
                rgb.insert(rgb.end(), {value, value, 0.5f * value});
            }
    s.set_size(z.size());
    s.add("xy", 2, xy);
    s.add("z", 1, z);
    s.add("rgb", 3, rgb);
    return s;
}

double squared_error(std::span<const float> a, std::span<const float> truth) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += double(a[i] - truth[i]) * double(a[i] - truth[i]);
    return sum / double(a.size());
}

TEST(SmoothRadiance, AConstantStaysConstant) {
    const Samples s = plane(20, 20, 2, [](float, float, float) { return 0.7f; });
    const Samples out = RunNode("smooth-radiance").in("samples", s).out<Samples>("samples");
    for (size_t i = 0; i < out.size(); ++i) EXPECT_NEAR(out.rgb()[3 * i], 0.7f, 1e-5f);
}

TEST(SmoothRadiance, NoiseOnAFlatSurfaceGoes) {
    const auto flat = plane(48, 48, 2, [](float, float, float) { return 0.5f; });
    const auto noisy = plane(48, 48, 2, [](float, float, float r) { return r; });
    const Samples out = RunNode("smooth-radiance").in("samples", noisy).out<Samples>("samples");
    EXPECT_LT(squared_error(out.rgb(), flat.rgb()), 0.05 * squared_error(noisy.rgb(), flat.rgb()));
}

TEST(SmoothRadiance, ACleanEdgeIsKept) {
    const Samples edge = plane(48, 48, 4, [](float x, float y, float) { return x + 0.3f * y < 30 ? 0.1f : 0.9f; });
    const Samples out = RunNode("smooth-radiance").in("samples", edge).out<Samples>("samples");
    size_t changed = 0;
    for (size_t i = 0; i < out.size(); ++i) changed += std::abs(out.rgb()[3 * i] - edge.rgb()[3 * i]) > 0.02f;
    EXPECT_LT(changed, out.size() / 50);
}

TEST(SmoothRadiance, FineDetailWithoutNoiseIsSharpened) {
    // A texture that a tent of the samples' spacing takes a sixth of the contrast of.
    const auto wave = [](float x, float y, float) { return 0.5f + 0.3f * std::sin(1.2f * x + 0.2f * y); };
    const Samples s = plane(48, 48, 4, wave);
    const Samples out = RunNode("smooth-radiance").in("samples", s).out<Samples>("samples");
    size_t sharper = 0;
    for (size_t i = 0; i < out.size(); ++i) sharper += std::abs(out.rgb()[3 * i] - 0.5f) > std::abs(s.rgb()[3 * i] - 0.5f) + 0.005f;
    EXPECT_GT(sharper, out.size() / 2);
}

TEST(SmoothRadiance, SamplesOfAnotherDepthDoNotMix) {
    Samples s = plane(32, 32, 2, [](float, float, float r) { return r; });
    // Every other sample lies far behind and is black.
    std::vector<float> z(s.z().begin(), s.z().end()), rgb(s.rgb().begin(), s.rgb().end());
    for (size_t i = 0; i < z.size(); i += 2) {
        z[i] = 50;
        rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = 0;
    }
    s.add("z", 1, z);
    s.add("rgb", 3, rgb);
    const Samples out = RunNode("smooth-radiance").in("samples", s).out<Samples>("samples");
    double front = 0;
    for (size_t i = 0; i < z.size(); ++i) {
        front += i % 2 ? out.rgb()[3 * i] : 0;
        if (i % 2 == 0) {
            EXPECT_EQ(out.rgb()[3 * i], 0);
        }
    }
    EXPECT_NEAR(front / (0.5 * double(z.size())), 0.5, 0.03);
}

TEST(SmoothRadiance, BlackAndEmptyBuffersComeOutAsTheyWere) {
    const Samples black = plane(5, 5, 1, [](float, float, float) { return 0.0f; });
    EXPECT_EQ(RunNode("smooth-radiance").in("samples", black).out<Samples>("samples").size(), black.size());
    Samples none;
    none.width = none.height = 3;
    none.spp = 1;
    none.add("xy", 2, {});
    none.add("z", 1, {});
    none.add("rgb", 3, {});
    EXPECT_EQ(RunNode("smooth-radiance").in("samples", none).out<Samples>("samples").size(), 0u);
}

TEST(SmoothRadiance, PredictionsAreThoseOfTheScalarForm) {
    using namespace light_field;
    PlainContext ctx;
    const Samples s = random_samples(24, 18, 3, Kind_of::moving_in_depth);
    Smoothing by;
    by.width = {1, 1.5f, 2.2f, 3.5f};
    by.depth = 0.1f;
    by.slope = 1;
    by.velocity = 2;
    const SampleField field = sample_field(s, 0.5f * by.width[3], ctx);
    for (Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        Predictions p;
        p.resize(field.x.size());
        const size_t pitch = field.x.size();
        WEFT_PICK(predict)(field, by, 0, field.size, p);
        WEFT_PICK(sharpen)(field, by, 0, field.size, p);
        std::vector<std::uint8_t> best(field.size);
        WEFT_PICK(choose)(field, by, p, 0, field.size, best);
        for (size_t i = 0; i < field.size; i += 7) {
            double sum[4][2] = {}, gain[5] = {}, spread[5] = {};
            for (size_t j = 0; j < field.size; ++j) {
                const double d = std::hypot(double(field.x[j] - field.x[i]), double(field.y[j] - field.y[i]));
                if (!(d < by.width[3]) || std::abs(field.slope[j] - field.slope[i]) > by.slope ||
                    std::abs(field.log_depth[j] - field.log_depth[i]) > by.depth || std::abs(field.velocity_x[j] - field.velocity_x[i]) > by.velocity ||
                    std::abs(field.velocity_y[j] - field.velocity_y[i]) > by.velocity)
                    continue;
                for (size_t k = 0; k < 4; ++k) {
                    double w = std::max(0.0, 1 - d / by.width[k]);
                    if (k == 0) w *= w;
                    sum[k][0] += w * field.r[j];
                    sum[k][1] += w;
                }
                for (size_t k = 1; k < 5; ++k) {
                    const double g = (1 - d / by.width[3]) * (p.error[k * pitch + j] - p.error[j]);
                    gain[k] += g;
                    spread[k] += g * g;
                }
            }
            size_t expected = 0;
            double least = 0, second = 1e9;
            for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(p.r[k * pitch + i], sum[k][0] / sum[k][1], 1e-4);
            EXPECT_NEAR(p.r[4 * pitch + i], std::max(0.0f, 2 * field.r[i] - p.r[i]), 1e-5);
            EXPECT_NEAR(p.weight[i], sum[0][1], 1e-4);
            for (size_t k = 1; k < 5; ++k) {
                const double score = gain[k] + (k == 4 ? by.sharp_caution : by.caution) * std::sqrt(spread[k]);
                if (score < least) second = least, least = score, expected = k;
                else second = std::min(second, score);
            }
            if (second - least > 1e-3) {
                EXPECT_EQ(best[i], expected);
            }
            // Leaving a sample out by its share in its own prediction is what leaving it out by hand gives.
            const double share = 1 / sum[0][1], guess = sum[0][0] * share, by_hand = (sum[0][0] - field.r[i]) / (sum[0][1] - 1);
            if (sum[0][1] > 1.01) {
                EXPECT_NEAR((field.r[i] - guess) / (1 - share), field.r[i] - by_hand, 1e-3);
            }

        }
    }
}

}  // namespace
}  // namespace weft
