// Adaptive sampling against functions whose pictures and trees are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <set>
#include <thread>

#include "adaptive/adaptive_tree.h"
#include "adaptive/leaf_tree.h"
#include "adaptive/metrics.h"
#include "adaptive/sampler_function.h"
#include "image/image.h"
#include "samples/samples.h"
#include "tests/run_node.h"

namespace weft {
namespace {
using namespace adaptive;

SamplerFunction sampler_of(const std::string& function, int width = 48, int height = 48) {
    return RunNode("test-sampler").set("function", Json(function)).set("width", Json(double(width))).set("height", Json(double(height))).out<SamplerFunction>("sampler");
}

struct Adaptive {
    Samples samples;
    LeafTree leaves;
    Image picture;
    std::vector<std::string> warnings;
};
Adaptive adaptive(const SamplerFunction& sampler, double budget, int seed = 1, double initial = 1) {
    Adaptive made;
    RunNode node("adaptive-samples");
    node.in("sampler", sampler).set("budget", Json(budget)).set("initial", Json(initial)).set("seed", Json(double(seed)));
    node.run({Slot{"samples", &type_info<Samples>(), &made.samples, {}}, Slot{"leaves", &type_info<LeafTree>(), &made.leaves, {}}});
    made.warnings = node.ctx.warnings;
    made.picture = RunNode("leaf-integrate").in("samples", made.samples).in("leaves", made.leaves).out<Image>("image");
    return made;
}

// The disc scene by 8 x 8 x 32 strata a pixel.
Image disc_reference(const SamplerFunction& sampler) {
    Image image(sampler.width, sampler.height, 3);
    constexpr int side = 8, times = 32;
    for (int py = 0; py < sampler.height; ++py)
        for (int px = 0; px < sampler.width; ++px) {
            std::vector<float> x, y, t;
            for (int k = 0; k < times; ++k)
                for (int j = 0; j < side; ++j)
                    for (int i = 0; i < side; ++i) {
                        x.push_back((float(px) + (float(i) + 0.5f) / side) / float(sampler.width));
                        y.push_back((float(py) + (float(j) + 0.5f) / side) / float(sampler.height));
                        t.push_back((float(k) + 0.5f) / times);
                    }
            std::vector<float> rgb(3 * x.size());
            const std::vector<std::span<const float>> axes{x, y, t};
            sampler.evaluate({axes}, 0, rgb);
            double sum = 0;
            for (size_t i = 0; i < x.size(); ++i) sum += double(rgb[3 * i]);
            for (int c = 0; c < 3; ++c) image.at(px, py)[c] = float(sum / double(x.size()));
        }
    return image;
}

double rmse(const Image& a, const Image& b) {
    double sum = 0;
    for (size_t i = 0; i < a.pixels().size(); ++i) sum += std::pow(double(a.pixels()[i]) - double(b.pixels()[i]), 2);
    return std::sqrt(sum / double(a.pixels().size()));
}

Image box_of(const Samples& samples) { return RunNode("pixel-filter").in("samples", samples).out<Image>("image"); }

TEST(AdaptiveTree, ErrorOfABoxIsItsVolumeTimesItsContrast) {
    const std::vector<float> grey{0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1};
    EXPECT_NEAR(leaf_error(grey, 2, Contrast::relative), 5.9880440, 1e-6);
    EXPECT_NEAR(leaf_error(grey, 2, Contrast::absolute), 2 * (1.5 + 1e-5), 1e-9);
}

TEST(AdaptiveTree, FiveSamplesAreCutIntoTwoAndThree) {
    const std::vector<float> along{0.1f, 0.2f, 0.4f, 0.7f, 0.9f};
    const float plane = plane_between(along);
    EXPECT_FLOAT_EQ(plane, 0.3f);
    EXPECT_EQ(std::ranges::count_if(along, [&](float x) { return x < plane; }), 2);
    EXPECT_EQ(plane_between(std::vector<float>(5, 0.5f)), 0.5f);
}

// The first box gets its fifth sample, and is cut between the second and the third along its longest side.
TEST(AdaptiveTree, ABoxIsCutBetweenItsSecondAndThirdSampleAcrossItsLongestSide) {
    TreeSettings settings{.extent = {4, 4, 64}};
    Tree tree(settings, 4, 4000);
    const size_t before = tree.leaves();
    ASSERT_EQ(tree.request(0), 4 * before);
    // The first box alone is worth another sample.
    std::vector<float> values(12 * before, 0.5f);
    values[0] = 0;
    tree.insert(values);
    ASSERT_EQ(tree.request(1), 1u);
    tree.insert(std::vector<float>(3, 0.5f));
    ASSERT_EQ(tree.leaves(), before + 1);
    const Tree::Leaf &kept = tree.leaf(0), &added = tree.leaf(before);
    EXPECT_EQ(kept.samples.size(), 2u);
    EXPECT_EQ(added.samples.size(), 3u);
    EXPECT_EQ(kept.hi[2], added.lo[2]);
    std::vector<float> along;
    for (const auto* leaf : {&kept, &added})
        for (const std::uint32_t s : leaf->samples) along.push_back(tree.at(2, s));
    std::sort(along.begin(), along.end());
    EXPECT_FLOAT_EQ(kept.hi[2], 0.5f * (along[1] + along[2]));
}

// A tree of `axes` axes that has been sampled for some rounds, by a function with edges across all.
Tree grown_tree(const TreeSettings& settings, int rounds) {
    Tree tree(settings, 400, 40000);
    for (int round = 0; round < rounds; ++round) {
        const size_t n = tree.request(300);
        std::vector<float> rgb;
        for (size_t i = 0; i < n; ++i) {
            float sum = 0;
            for (size_t d = 0; d < tree.dimensions(); ++d) sum += tree.places(d)[i] * float(d + 1);
            rgb.insert(rgb.end(), 3, std::fmod(sum, 1.0f));
        }
        tree.insert(rgb);
    }
    return tree;
}

TEST(AdaptiveTree, KnowsWhichBoxesShareAFace) {
    const std::vector<std::vector<float>> domains{{17, 12}, {24, 20, 9}, {12, 16, 8, 5}, {8, 9, 5, 12, 4}};
    for (const auto& extent : domains) {
        const Tree tree = grown_tree({.extent = extent, .reach = Reach::neighbours}, 6);
        const size_t axes = extent.size();
        ASSERT_GT(tree.leaves(), 100u);
        for (std::uint32_t a = 0; a < tree.leaves(); ++a) {
            std::set<std::uint32_t> expected;
            for (std::uint32_t b = 0; b < tree.leaves(); ++b) {
                // Their common part is flat along one axis, and no further one.
                size_t flat = 0, apart = 0;
                for (size_t d = 0; d < axes; ++d) {
                    const float common = std::min(tree.leaf(a).hi[d], tree.leaf(b).hi[d]) - std::max(tree.leaf(a).lo[d], tree.leaf(b).lo[d]);
                    flat += common == 0, apart += common < 0;
                }
                if (a != b && flat == 1 && apart == 0) expected.insert(b);
            }
            const auto found = tree.neighbours(a);
            ASSERT_EQ(found.size(), expected.size()) << "each once";
            ASSERT_EQ(std::set<std::uint32_t>(found.begin(), found.end()), expected) << a << " of " << axes << " axes";
        }
    }
}

// Two trees that are alike try the same places; each takes the farthest, of those samples that it looks at.
TEST(AdaptiveTree, PlacesAreFarFromSamplesWithinReach) {
    const std::vector<float> extent{16, 16, 12};
    TreeSettings settings{.extent = extent, .candidates = 16};
    Tree alone(settings, 400, 4000);
    settings.reach = Reach::neighbours;
    Tree beyond(settings, 400, 4000);
    const size_t first = alone.request(0), cells = alone.leaves();
    ASSERT_EQ(beyond.request(0), first);
    std::vector<float> rgb;  // unlike within every cell
    for (size_t i = 0; i < first; ++i) rgb.insert(rgb.end(), 3, float(i % 2));
    alone.insert(rgb), beyond.insert(rgb);
    const size_t n = alone.request(cells);
    ASSERT_EQ(beyond.request(cells), n);
    const auto place = [&](const Tree& tree, size_t i) {
        std::array<float, 3> at{};
        for (size_t d = 0; d < 3; ++d) at[d] = tree.places(d)[i] * extent[d];
        return at;
    };
    const auto box_at = [&](const std::array<float, 3>& at) {
        for (size_t l = 0; l < cells; ++l) {
            bool inside = true;
            for (size_t d = 0; d < 3; ++d) inside = inside && at[d] > beyond.leaf(l).lo[d] && at[d] < beyond.leaf(l).hi[d];
            if (inside) return l;
        }
        return cells;
    };
    size_t differ = 0, checked = 0;
    for (size_t i = 0; i < n; ++i) {
        const auto a = place(alone, i), b = place(beyond, i);
        const size_t l = box_at(a);
        if (l == cells || box_at(b) != l) continue;  // on a side, by rounding
        const auto nearest = [&](const std::array<float, 3>& at, bool further) {
            std::vector<std::uint32_t> boxes{std::uint32_t(l)};
            if (further) boxes.insert(boxes.end(), beyond.neighbours(l).begin(), beyond.neighbours(l).end());
            double least = 1e30;
            for (const std::uint32_t box : boxes)
                for (const std::uint32_t s : beyond.leaf(box).samples) {
                    double sum = 0;
                    for (size_t d = 0; d < 3; ++d) sum += std::pow(double(beyond.at(d, s)) - double(at[d]), 2);
                    least = std::min(least, sum);
                }
            return std::sqrt(least);
        };
        EXPECT_GE(nearest(b, true), nearest(a, true) - 1e-4);
        EXPECT_GE(nearest(a, false), nearest(b, false) - 1e-4);
        differ += a != b, ++checked;
    }
    EXPECT_GT(checked, n / 2);
    EXPECT_GT(differ, n / 4);
}

class OfFunction : public testing::TestWithParam<const char*> {};

TEST_P(OfFunction, BoxesPartTheDomainAndItsSamples) {
    const Adaptive made = adaptive(sampler_of(GetParam(), 24, 20), 6);
    const size_t axes = made.leaves.dimensions();
    double volume = 0, all = 1;
    for (const float e : made.leaves.extent) all *= double(e);
    std::set<std::uint32_t> seen;
    for (size_t l = 0; l < made.leaves.size(); ++l) {
        volume += made.leaves.volume(l);
        for (std::uint32_t k = made.leaves.first[l]; k < made.leaves.first[l + 1]; ++k) {
            const std::uint32_t s = made.leaves.samples[k];
            EXPECT_TRUE(seen.insert(s).second) << "in two boxes";
            const float place[3] = {made.samples.xy()[2 * s], made.samples.xy()[2 * s + 1], made.samples.t()[s] * made.leaves.extent[2]};
            for (size_t d = 0; d < axes; ++d) {
                EXPECT_GE(place[d], made.leaves.lo[l * axes + d] - 1e-4f);
                EXPECT_LE(place[d], made.leaves.hi[l * axes + d] + 1e-4f);
            }
        }
    }
    EXPECT_NEAR(volume / all, 1, 1e-6);
    EXPECT_EQ(seen.size(), made.samples.size());
    EXPECT_EQ(made.samples.size(), 6u * 24 * 20);
    // Weights are volumes in pixels, so they add up to the number of pixels.
    double weight = 0;
    for (const float w : made.samples.values("weight")) weight += double(w);
    EXPECT_NEAR(weight / (24 * 20), 1, 1e-5);
}
INSTANTIATE_TEST_SUITE_P(All, OfFunction, testing::Values("constant", "linear", "time", "texture", "edge", "noise"));

TEST(AdaptiveSamples, OfAConstantIsThatConstant) {
    const Adaptive made = adaptive(sampler_of("constant", 20, 16), 4);
    for (const float value : made.picture.pixels()) EXPECT_EQ(value, 0.5f);
}

TEST(LeafIntegrate, TakesTensorsThatAreThereAlready) {
    const Adaptive made = adaptive(sampler_of("disc"), 4), other = adaptive(sampler_of("disc"), 3);
    const auto picture_by = [&](const Adaptive& of) {
        const Metrics tensors = RunNode("structure-tensors").in("samples", of.samples).in("leaves", of.leaves).out<Metrics>("tensors");
        return RunNode("leaf-integrate").in("samples", made.samples).in("leaves", made.leaves).in("tensors", tensors).out<Image>("image");
    };
    const Image picture = picture_by(made);
    EXPECT_TRUE(std::ranges::equal(picture.pixels(), made.picture.pixels()));
    EXPECT_NE(error_of([&] { picture_by(other); }).find("other samples"), std::string::npos);
}

TEST(AdaptiveSamples, OfARampIsTheRampWithinABox) {
    const Adaptive made = adaptive(sampler_of("linear", 24, 24), 8);
    float widest = 0;
    for (size_t l = 0; l < made.leaves.size(); ++l) widest = std::max(widest, made.leaves.hi[3 * l] - made.leaves.lo[3 * l]);
    for (int x = 0; x < 24; ++x) EXPECT_NEAR(made.picture.at(x, 11)[0], (float(x) + 0.5f) / 24, widest / 24);
}

TEST(AdaptiveSamples, OfTimeAloneIsHalfEverywhere) {
    const Adaptive made = adaptive(sampler_of("time", 16, 16), 8);
    float widest = 0;
    for (size_t l = 0; l < made.leaves.size(); ++l) widest = std::max(widest, (made.leaves.hi[3 * l + 2] - made.leaves.lo[3 * l + 2]) / made.leaves.extent[2]);
    for (const float value : made.picture.pixels()) EXPECT_NEAR(value, 0.5f, widest);
}

// Against the means of evenly, and well, spread samples, which a moving texture leaves noisy.
TEST(AdaptiveSamples, OfAMovingDiscBeatEvenOnes) {
    const SamplerFunction sampler = sampler_of("disc");
    const Image reference = disc_reference(sampler);
    const Samples even = RunNode("uniform-samples").in("sampler", sampler).set("per-pixel", Json(4.0)).out<Samples>("samples");
    const double plain = rmse(box_of(even), reference);
    EXPECT_GT(plain, 0.03);
    for (const int seed : {1, 2, 3}) {
        const Adaptive made = adaptive(sampler, 4, seed);
        EXPECT_LT(rmse(made.picture, reference), 0.2 * plain) << "seed " << seed;
        // Boxes of one brightness have what their samples' places leave to chance as well.
        const Image flat = RunNode("leaf-integrate").in("samples", made.samples).in("leaves", made.leaves).set("order", Json("constant")).out<Image>("image");
        EXPECT_LT(rmse(flat, reference), 0.65 * plain) << "seed " << seed;
        // More of them are where the disc passes, and weights make up for that.
        double in_path = 0, weighted = 0, weights = 0, mean = 0;
        for (size_t i = 0; i < made.samples.size(); ++i) {
            in_path += std::abs(made.samples.xy()[2 * i + 1] - 24) < 10;
            weighted += double(made.samples.values("weight")[i]) * double(made.samples.rgb()[3 * i]);
            weights += double(made.samples.values("weight")[i]);
        }
        for (const float value : reference.pixels()) mean += double(value) / double(reference.pixels().size());
        EXPECT_GT(in_path / double(made.samples.size()), 1.05 * 20 / 48);
        EXPECT_NEAR(weighted / weights, mean, 0.01 * mean);
    }
}

// A function of the film alone, a picture one pixel high, and one of a single pixel.
TEST(AdaptiveSamples, OfFewAxesAndOfALineAreRight) {
    SamplerFunction film = sampler_of("texture", 40, 12);
    film.axes.resize(2);
    const auto with_time = film.evaluate;
    film.evaluate = [with_time](const SamplerPoints& points, std::uint64_t seed, std::span<float> rgb) {
        const std::vector<float> t(points.size());
        const std::vector<std::span<const float>> axes{points.axes[0], points.axes[1], t};
        with_time({axes}, seed, rgb);
    };
    const auto texture = [](int x, double v) {
        const auto sinc = [](double a) { return a == 0 ? 1 : std::sin(std::numbers::pi * a) / (std::numbers::pi * a); };
        return 0.5 + 0.5 * sinc(v / 8) * sinc(1.0 / 8) * std::sin(2 * std::numbers::pi * (x + 0.5 - v / 2) / 8);
    };
    const auto off = [&](const Image& picture, double v) {
        double sum = 0;
        for (int y = 0; y < picture.height(); ++y)
            for (int x = 0; x < picture.width(); ++x) sum += std::pow(double(picture.at(x, y)[0]) - texture(x, v), 2);
        return std::sqrt(sum / double(picture.width() * picture.height()));
    };
    EXPECT_LT(off(adaptive(film, 8).picture, 0), 0.015);
    EXPECT_LT(off(adaptive(sampler_of("texture", 64, 1), 16).picture, 6), 0.04);
    const Adaptive dot = adaptive(sampler_of("time", 1, 1), 64, 1, 8);
    EXPECT_NEAR(dot.picture.at(0, 0)[0], 0.5f, 0.03f);
}

TEST(AdaptiveSamples, AreTheSameHoweverLargeTheBudgetIsUntilTheSmallerOneEnds) {
    TreeSettings settings{.extent = {16, 16, 28}};
    const SamplerFunction sampler = sampler_of("disc", 48, 48);
    const auto sampled = [&](size_t budget) {
        Tree tree(settings, 256, 3000);
        std::vector<float> places;
        while (tree.samples() < budget) {
            const size_t n = tree.request(budget - tree.samples());
            std::vector<std::span<const float>> axes;
            for (size_t d = 0; d < 3; ++d) axes.push_back(tree.places(d));
            std::vector<float> rgb(3 * n);
            sampler.evaluate({axes}, 0, rgb);
            tree.insert(rgb);
        }
        for (size_t i = 0; i < tree.samples(); ++i) places.push_back(tree.at(0, i));
        return places;
    };
    const auto small = sampled(1500), large = sampled(3000);
    // The round in which the small budget ended was cut short.
    for (size_t i = 0; i < 1200; ++i) ASSERT_EQ(small[i], large[i]) << i;
}

// A renderer that takes longer than there is time for: the rounds so far are a buffer like any other.
TEST(AdaptiveSamples, EndWhenTheirTimeIsOver) {
    SamplerFunction slow = sampler_of("disc", 16, 16);
    const auto disc = slow.evaluate;
    slow.evaluate = [disc](const SamplerPoints& points, std::uint64_t seed, std::span<float> rgb) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        disc(points, seed, rgb);
    };
    const auto samples_in = [&](double seconds) {
        return RunNode("adaptive-samples").in("sampler", slow).set("budget", Json(8.0)).set("seconds", Json(seconds)).out<Samples>("samples");
    };
    const Samples cut = samples_in(0.001), whole = samples_in(0);
    EXPECT_GT(cut.size(), 0u);
    EXPECT_LT(cut.size(), whole.size());
    EXPECT_EQ(whole.size(), 8u * 16 * 16);
    double weight = 0;
    for (const float w : cut.values("weight")) weight += double(w);
    EXPECT_NEAR(weight / (16 * 16), 1, 1e-5);
}

TEST(AdaptiveSamples, NoiseThatNoAxisExplainsIsNoticed) {
    EXPECT_TRUE(adaptive(sampler_of("disc"), 3).warnings.empty());
    const Adaptive noisy = adaptive(sampler_of("noise", 24, 24), 4);
    ASSERT_EQ(noisy.warnings.size(), 1u);
    EXPECT_NE(noisy.warnings[0].find("no axis explains"), std::string::npos) << noisy.warnings[0];
    // And taken off.
    EXPECT_FALSE(has_hidden_noise(adaptive(sampler_of("disc"), 3).samples));
    EXPECT_TRUE(has_hidden_noise(noisy.samples));
    const auto radiance_by = [&](const char* smooth) {
        return RunNode("structure-tensors").in("samples", noisy.samples).in("leaves", noisy.leaves).set("smooth", Json(smooth)).out<Metrics>("tensors").radiance;
    };
    EXPECT_EQ(radiance_by("auto"), radiance_by("always"));
    EXPECT_NE(radiance_by("auto"), radiance_by("never"));
}

std::string error_of(const SamplerFunction& sampler, double budget) {
    try {
        adaptive(sampler, budget);
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

TEST(AdaptiveSamples, SayWhatIsWrong) {
    EXPECT_NE(error_of(sampler_of("disc", 8, 8), 0.02).find("raise budget"), std::string::npos);
    SamplerFunction line = sampler_of("disc");
    line.axes.resize(1);
    EXPECT_NE(error_of(line, 4).find("1 axes"), std::string::npos);
    SamplerFunction broken = sampler_of("disc");
    const auto good = broken.evaluate;
    const auto break_below = [&](float part) {
        broken.evaluate = [good, part](const SamplerPoints& points, std::uint64_t seed, std::span<float> rgb) {
            good(points, seed, rgb);
            for (size_t i = 0; i < points.size(); ++i)
                if (points.axes[0][i] < part) rgb[3 * i + 1] = std::numeric_limits<float>::quiet_NaN();
        };
    };
    break_below(0.5f);
    EXPECT_NE(error_of(broken, 4).find("not finite"), std::string::npos);
    break_below(0.004f);
    const Adaptive few = adaptive(broken, 4);
    ASSERT_GE(few.warnings.size(), 1u);
    EXPECT_NE(few.warnings[0].find("count as black"), std::string::npos);
    for (const float value : few.picture.pixels()) EXPECT_TRUE(std::isfinite(value));
}

}  // namespace
}  // namespace weft
