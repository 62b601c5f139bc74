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

// All samples at hand.
light_field::SampleField whole_field(const Samples& samples, float radius) {
    PlainContext ctx;
    light_field::SampleField s = light_field::sample_field(samples, radius, ctx);
    light_field::make_room(samples, s.size, s);
    light_field::fetch(samples, std::array{samples.rgb()}, 0, s.rows, s, ctx);
    return s;
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

TEST(SmoothRadiance, BrightSpotsKeepTheirTotal) {
    // Still, sharp, 200 times as bright as what is around them; two pixels wide, 16 apart.
    const auto spots = [](float x, float y, float) {
        return std::hypot(std::remainder(x - 8.3f, 16.0f), std::remainder(y - 7.6f, 16.0f)) < 1 ? 20.0f : 0.1f;
    };
    for (int spp : {1, 2, 3, 4, 5, 6, 8}) {
        const Samples s = plane(96, 96, spp, spots);
        const Samples out = RunNode("smooth-radiance").in("samples", s).out<Samples>("samples");
        double before = 0, after = 0;
        for (size_t i = 0; i < s.size(); ++i) {
            before += s.rgb()[3 * i];
            after += out.rgb()[3 * i];
        }
        EXPECT_NEAR(after / before, 1, 0.01) << spp << " spp";
    }
}

TEST(SmoothRadiance, AnOutlierLeavesNoBlackNeighbours) {
    // Texture fine enough to be sharpened, with one sample in 300 that is far too bright.
    const auto wave = [](float x, float y, float) { return 0.5f + 0.3f * std::sin(1.2f * x + 0.2f * y); };
    const Samples s = plane(48, 48, 4, [&](float x, float y, float r) { return r < 0.0033f ? 30.0f : wave(x, y, r); });
    const Samples out = RunNode("smooth-radiance").in("samples", s).out<Samples>("samples");
    for (size_t i = 0; i < out.size(); ++i) {
        // Sharpening goes past the least and the greatest around by no more than a quarter of the least.
        EXPECT_GE(out.rgb()[3 * i], 0.75f * 0.1999f);
        EXPECT_LE(out.rgb()[3 * i], 30 + 0.25f * 0.8001f);
    }
}

TEST(SmoothRadiance, NoiseGoesAtAnyNumberOfSamples) {
    for (int spp = 1; spp <= 8; ++spp) {
        const auto flat = plane(64, 64, spp, [](float, float, float) { return 0.5f; });
        const auto noisy = plane(64, 64, spp, [](float, float, float r) { return r; });
        const Samples out = RunNode("smooth-radiance").in("samples", noisy).out<Samples>("samples");
        EXPECT_LT(squared_error(out.rgb(), flat.rgb()), 0.05 * squared_error(noisy.rgb(), flat.rgb())) << spp << " spp";
    }
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

// Two kinds of samples in turn, noise and black.
Samples mixed_with_black() {
    Samples s = plane(32, 32, 2, [](float, float, float r) { return r; });
    std::vector<float> rgb(s.rgb().begin(), s.rgb().end());
    for (size_t i = 0; i < rgb.size(); i += 6) rgb[i] = rgb[i + 1] = rgb[i + 2] = 0;
    s.add("rgb", 3, rgb);
    return s;
}
void expect_apart(const Samples& samples) {
    const Samples out = RunNode("smooth-radiance").in("samples", samples).out<Samples>("samples");
    double noisy = 0;
    for (size_t i = 0; i < out.size(); ++i) {
        if (i % 2) noisy += out.rgb()[3 * i];
        else EXPECT_NEAR(out.rgb()[3 * i], 0, 1e-6);
    }
    EXPECT_NEAR(noisy / (0.5 * double(out.size())), 0.5, 0.03);
}

TEST(SmoothRadiance, SamplesOfAnotherNormalDoNotMix) {
    Samples s = mixed_with_black();
    std::vector<float> normal;
    for (size_t i = 0; i < s.size(); ++i) {
        if (i % 2) normal.insert(normal.end(), {0, 0, 1});
        else normal.insert(normal.end(), {0, 0.6f, 0.8f});  // 36 degrees from it
    }
    s.add("normal", 3, normal);
    expect_apart(s);
}

TEST(SmoothRadiance, SamplesOfAnotherAlbedoDoNotMix) {
    Samples s = mixed_with_black();
    std::vector<float> albedo;
    for (size_t i = 0; i < s.size(); ++i) albedo.insert(albedo.end(), {0.5f, i % 2 ? 0.5f : 0.7f, 0.5f});
    s.add("albedo", 3, albedo);
    expect_apart(s);
}

TEST(SmoothRadiance, ARidgeKeepsItsTwoSidesApart) {
    // Two planes that meet at x = 24, of unlike brightness, both noisy.
    const auto truth = [](float x) { return x < 24 ? 0.2f : 0.8f; };
    Samples s = plane(48, 48, 4, [&](float x, float, float r) { return truth(x) * 2 * r; });
    std::vector<float> normal;
    for (size_t i = 0; i < s.size(); ++i) normal.insert(normal.end(), {s.xy()[2 * i] < 24 ? -0.3f : 0.3f, 0, 0.954f});
    s.add("normal", 3, normal);
    const auto error = [&](double tolerance) {
        const Samples out = RunNode("smooth-radiance").set("normal-tolerance", tolerance).in("samples", s).out<Samples>("samples");
        double sum = 0;
        size_t n = 0;
        for (size_t i = 0; i < s.size(); ++i) {
            const float x = s.xy()[2 * i];
            if (std::abs(x - 24) > 4) continue;
            sum += std::pow(double(out.rgb()[3 * i] - truth(x)), 2);
            ++n;
        }
        return sum / double(n);
    };
    EXPECT_LT(error(0.55), 0.7 * error(1e6));
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

// What two parts of the light share is worked out once; what comes out is the same.
TEST(SmoothRadiance, PartsAsEachByItself) {
    const Samples rest = random_samples(60, 50, 3, Kind_of::moving_in_depth);
    Samples direct = rest, black = rest;
    std::vector<float> rgb(rest.rgb().begin(), rest.rgb().end());
    for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = 3 + rgb[i] * std::sin(float(i));
    direct.add("rgb", 3, rgb);
    black.add("rgb", 3, std::vector<float>(rgb.size(), 0.0f));
    const auto alone = [](const Samples& samples) {
        return RunNode("smooth-radiance").in("samples", samples).out<Samples>("samples");
    };
    for (Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        RunNode both("smooth-parts");
        both.in("rest", rest).in("direct", direct);
        EXPECT_TRUE(std::ranges::equal(both.out<Samples>("rest").rgb(), alone(rest).rgb()));
        EXPECT_TRUE(std::ranges::equal(both.out<Samples>("direct").rgb(), alone(direct).rgb()));
        Samples one, other;
        both.run({Slot{"rest", &type_info<Samples>(), &one, {}}, Slot{"direct", &type_info<Samples>(), &other, {}}});
        EXPECT_TRUE(std::ranges::equal(one.rgb(), alone(rest).rgb()));
        EXPECT_TRUE(std::ranges::equal(other.rgb(), alone(direct).rgb()));
        RunNode unlit("smooth-parts");
        unlit.in("rest", black).in("direct", direct);
        EXPECT_TRUE(std::ranges::equal(unlit.out<Samples>("direct").rgb(), alone(direct).rgb()));
    }
}

// A field is gone through in bands of rows, of which no sample is to notice anything.
TEST(SmoothRadiance, InBandsItIsAsInOne) {
    using namespace light_field;
    PlainContext ctx;
    const Samples samples = random_samples(500, 400, 1, Kind_of::moving_in_depth);
    const float radius = dispersion_radius(1);
    Smoothing by;
    const Array<float> smoothed = smooth_radiance(samples, std::array{samples.rgb()}, radius, 4, by, ctx)[0];
    for (size_t k = 0; k < Smoothing::widths; ++k)
        by.width[k] = radius * std::pow(4.0f, float(k) / float(Smoothing::widths - 1));
    by.window = by.width.back();
    const SampleField s = whole_field(samples, radius);
    ASSERT_GT(s.size, 3 * 65536u);
    const size_t blocks = s.blocks.size();
    Filtered filtered(s.size);
    Changes changes(s.size);
    std::vector<float> rgb(3 * s.size);
    std::span<float> to = rgb;
    WEFT_PICK(filter_samples)(s, by, 0, blocks, filtered);
    WEFT_PICK(find_errors)(s, filtered, by, 0, blocks, changes);
    WEFT_PICK(treat)(s, filtered, changes, by, 0, blocks, &to);
    EXPECT_TRUE(std::ranges::equal(smoothed.view(), rgb));
}

TEST(SmoothRadiance, ChoosesAsTheScalarFormDoes) {
    using namespace light_field;
    PlainContext ctx;
    Samples samples = random_samples(24, 18, 3, Kind_of::moving_in_depth);
    std::vector<float> normal;
    for (size_t i = 0; i < samples.size(); ++i) normal.insert(normal.end(), {0.4f * std::sin(float(i)), 0.3f * std::cos(3.0f * float(i)), -1});
    samples.add("normal", 3, normal);
    Smoothing by;
    by.normal = 1.2f;
    by.width = {1, 1.8f, 3.5f};
    by.depth = 0.1f;
    by.slope = 1;
    by.velocity = 2;
    by.epsilon = {0.2f};
    const SampleField s = whole_field(samples, 0.8f);
    by.window = 2.5f;
    const size_t n = s.size, sharp = Smoothing::treatments - 1;
    // Distance on one surface; -1 where two samples are of different ones.
    const auto distance = [&](size_t i, size_t j) {
        if (std::abs(s.slope[j] - s.slope[i]) > by.slope || std::abs(s.log_depth[j] - s.log_depth[i]) > by.depth ||
            std::abs(s.velocity_x[j] - s.velocity_x[i]) > by.velocity || std::abs(s.velocity_y[j] - s.velocity_y[i]) > by.velocity)
            return -1.0;
        return std::hypot(double(s.x[j] - s.x[i]), double(s.y[j] - s.y[i]));
    };
    const auto likeness = [&](size_t i, size_t j) {
        double apart = 0;
        for (const auto& part : s.normal) apart += std::pow(double(part[i] - part[j]), 2);
        return std::max(0.0, 1 - apart / (by.normal * by.normal));
    };
    const auto weight = [&](size_t k, size_t i, size_t j) {
        const double d = distance(i, j) / by.width[k];
        if (d < 0 || d > 1) return 0.0;
        return k == 0 ? (1 - d) * (1 - d) : (1 - d * d) * likeness(i, j);
    };
    const std::span<const float> y[3] = {s.color[0].r, s.color[0].g, s.color[0].b};
    // Prediction of sample i by treatment k from the radiance `of`, without sample `out`.
    const auto mean = [&](size_t k, size_t i, const std::vector<double>& of, size_t out) {
        double sum = 0, all = 0;
        for (size_t j = 0; j < n; ++j) {
            if (j == out) continue;
            sum += weight(k, i, j) * of[j];
            all += weight(k, i, j);
        }
        return all > 0 ? sum / all : std::nan("");
    };
    std::vector<double> radiance[3], sharpened[3];
    for (size_t c = 0; c < 3; ++c) {
        radiance[c].assign(y[c].begin(), y[c].begin() + std::ptrdiff_t(n));
        for (size_t i = 0; i < n; ++i) sharpened[c].push_back(2 * radiance[c][i] - mean(0, i, radiance[c], n));
    }
    for (Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        Filtered filtered(n);
        const size_t blocks = s.blocks.size();
        WEFT_PICK(filter_samples)(s, by, 0, blocks, filtered);
        Changes changes(n);
        WEFT_PICK(find_errors)(s, filtered, by, 0, blocks, changes);
        std::vector<float> rgb(samples.rgb().begin(), samples.rgb().end());
        std::span<float> to = rgb;
        WEFT_PICK(treat)(s, filtered, changes, by, 0, blocks, &to);

        for (size_t i = 0; i < n; i += 5) EXPECT_NEAR(filtered.color[0].g[i], mean(0, i, radiance[1], n), 1e-4);
        for (size_t i = 0; i < n; i += 11) {
            if (filtered.weight[i] < 1.01f) continue;  // all but nothing is left without the sample
            double wide[3], as_is[3];
            for (size_t c = 0; c < 3; ++c) {
                wide[c] = mean(Smoothing::widths - 1, i, radiance[c], n);
                as_is[c] = radiance[c][i] - mean(0, i, radiance[c], i);
            }
            // What treatment k gains and how far it goes, by what it leaves of each channel.
            const auto expect = [&](size_t k, auto&& left, double precision) {
                double gain = 0, way = 0, error = 0;
                for (size_t c = 0; c < 3; ++c) {
                    const double off = left(c), level = wide[c] * wide[c] + 0.04;
                    error += (off * off + as_is[c] * as_is[c]) / level;
                    gain += (off * off - as_is[c] * as_is[c]) / level;
                    way += (off - as_is[c]) * (off - as_is[c]) / level;
                }
                if (!std::isfinite(error)) return;
                EXPECT_NEAR(changes.color[0][k - 1].gain[i], gain, precision * error + 1e-4) << k;
                EXPECT_NEAR(changes.color[0][k - 1].way[i], way, precision * error + 1e-4) << k;
            };
            for (size_t k = 1; k < Smoothing::widths; ++k)
                expect(k, [&](size_t c) { return radiance[c][i] - mean(k, i, radiance[c], i); }, 1e-3);
            // Sharpened: the sample left out of both filterings, by its share in the result.
            double share = 0, all = 0;
            for (size_t j = 0; j < n; ++j) all += weight(0, i, j);
            for (size_t j = 0; j < n; ++j) {
                double of_j = 0;
                for (size_t l = 0; l < n; ++l) of_j += weight(0, j, l);
                share += weight(0, i, j) * weight(0, j, i) / (all * of_j);
            }
            share = 2 / all - share;
            if (share < 0.9) expect(sharp, [&](size_t c) { return (radiance[c][i] - mean(0, i, sharpened[c], n)) / (1 - share); }, 2e-3);
        }
        size_t compared = 0;
        for (size_t i = 0; i < n; i += 3) {
            double best_score = 0, second = 1e9, part = 0;
            size_t expected = 0;
            for (size_t k = 1; k < Smoothing::treatments; ++k) {
                double gain = 0, spread = 0, way = 0;
                for (size_t j = 0; j < n; ++j) {
                    const double d = distance(i, j) / by.window;
                    if (d < 0 || d >= 1) continue;
                    const double w = (1 - d * d) * likeness(i, j), g = w * double(changes.color[0][k - 1].gain[j]);
                    gain += g;
                    spread += g * g;
                    way += w * double(changes.color[0][k - 1].way[j]);
                }
                gain += (k == sharp ? by.sharp_caution : by.caution) * std::sqrt(spread);
                // The least error of all mixes, by trying them.
                double score = 0, of_it = 0;
                for (int step = 1; step <= 1000; ++step) {
                    const double a = 0.001 * step, error = a * (gain - way) + a * a * way;
                    if (error < score) score = error, of_it = a;
                }
                if (score < best_score) second = best_score, best_score = score, expected = k, part = of_it;
                else second = std::min(second, score);
            }
            if (second - best_score < 1e-3 || (expected == 0 && second < 1e-3)) continue;
            ++compared;
            double least = radiance[0][i], greatest = least;
            for (size_t j = 0; j < n; ++j) {
                if (weight(0, i, j) == 0) continue;
                least = std::min(least, radiance[0][j]);
                greatest = std::max(greatest, radiance[0][j]);
            }
            const double past = 0.25 * least, sharper = std::clamp(sharpened[0][i], least - past, greatest + past);
            const double treated = expected == 0 ? radiance[0][i] : expected == sharp ? sharper : mean(expected, i, radiance[0], n);
            const double red = radiance[0][i] + part * (treated - radiance[0][i]);
            if (std::isfinite(red)) {
                EXPECT_NEAR(rgb[3 * s.order[i]], red, 1e-3);
            }
        }
        EXPECT_GT(compared, 100u);
    }
}

}  // namespace
}  // namespace weft
