// Reconstruction by each sample's own distance, against exact answers and plain searches.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "adaptive/anisotropic_radiance.h"
#include "adaptive/least_distance_kernel.h"
#include "adaptive/metrics.h"
#include "adaptive/near_samples.h"
#include "adaptive/neighbourhood_kernel.h"
#include "adaptive/sampler_function.h"
#include "adaptive/structure_tensors_kernel.h"
#include "tests/graph_run.h"

namespace weft {
namespace {
using namespace adaptive;

std::vector<std::vector<float>> random_points(size_t n, size_t axes, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> number(0, 16);
    std::vector<std::vector<float>> at(axes, std::vector<float>(n));
    for (auto& axis : at)
        for (float& x : axis) x = number(random);
    return at;
}
PointTree tree_of(const std::vector<std::vector<float>>& at) {
    return PointTree(std::vector<std::span<const float>>(at.begin(), at.end()));
}

TEST(PointTree, FindsTheNearestAsAPlainSearchDoes) {
    for (const size_t axes : {2u, 3u, 5u, 6u}) {
        auto at = random_points(700, axes, unsigned(axes));
        for (size_t i = 0; i < 40; ++i)  // points in one place
            for (auto& axis : at) axis[i + 100] = axis[3];
        const PointTree tree = tree_of(at);
        const auto queries = random_points(50, axes, 77);
        for (size_t q = 0; q < 50; ++q) {
            std::vector<float> p;
            for (const auto& axis : queries) p.push_back(axis[q]);
            std::vector<PointTree::Near> all, found;
            for (std::uint32_t i = 0; i < tree.size(); ++i) {
                float d2 = 0;
                for (size_t d = 0; d < axes; ++d) d2 += (tree.at(d)[i] - p[d]) * (tree.at(d)[i] - p[d]);
                all.push_back({d2, i});
            }
            std::sort(all.begin(), all.end());
            tree.nearest(p.data(), 16, found);
            ASSERT_EQ(found.size(), 16u);
            for (size_t k = 0; k < 16; ++k) EXPECT_EQ(found[k].place, all[k].place) << axes;
        }
    }
}

TEST(PointTree, OfManyEqualPointsEndsAndHoldsAll) {
    const std::vector<std::vector<float>> at(3, std::vector<float>(1000, 2.0f));
    const PointTree tree = tree_of(at);
    std::vector<bool> seen(1000);
    for (const std::uint32_t i : tree.order()) seen[i] = true;
    EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 1000);
}

TEST(Symmetric, EigenvaluesAndVectorsMakeTheMatrixAgain) {
    std::mt19937 random(5);
    std::normal_distribution<double> number;
    for (size_t n = 1; n <= most_axes; ++n) {
        Matrix m{}, vectors;
        for (size_t a = 0; a < n; ++a)
            for (size_t b = 0; b <= a; ++b) m[a][b] = m[b][a] = number(random);
        const auto values = eigen(m, n, vectors);
        for (size_t a = 0; a < n; ++a)
            for (size_t b = 0; b < n; ++b) {
                double sum = 0;
                for (size_t k = 0; k < n; ++k) sum += values[k] * vectors[a][k] * vectors[b][k];
                EXPECT_NEAR(sum, m[a][b], 1e-11);
            }
    }
}

Matrix matrix_of(const float* upper, size_t n) {
    Matrix m{};
    for (size_t a = 0; a < n; ++a)
        for (size_t b = a; b < n; ++b) m[a][b] = m[b][a] = double(upper[upper_index(a, b, n)]);
    return m;
}
std::array<double, most_axes> steepest(const float* upper, size_t n, double& product, double& ratio) {
    Matrix vectors;
    const auto values = eigen(matrix_of(upper, n), n, vectors);
    size_t best = 0;
    product = 1;
    double least = values[0];
    for (size_t k = 0; k < n; ++k) {
        if (values[k] > values[best]) best = k;
        product *= values[k];
        least = std::min(least, values[k]);
    }
    ratio = least / values[best];
    std::array<double, most_axes> vector{};
    for (size_t d = 0; d < n; ++d) vector[d] = vectors[d][best];
    return vector;
}

TEST(StructureTensors, OfALinearFunctionAreExact) {
    PlainContext ctx;
    for (size_t axes = 2; axes <= 6; ++axes) {
        const PointTree tree = tree_of(random_points(600, axes, unsigned(axes)));
        std::mt19937 random(unsigned(axes) * 7);
        std::normal_distribution<float> number;
        std::vector<float> slope(axes), rgb;
        for (float& s : slope) s = 0.05f * number(random);
        for (size_t i = 0; i < tree.size(); ++i) {
            float f = 0.5f;
            for (size_t d = 0; d < axes; ++d) f += slope[d] * tree.at(d)[i];
            rgb.insert(rgb.end(), 3, f);
        }
        const TensorSettings settings{.neighbours = 3 * axes, .averaged = 24, .floor = 0.05f, .ridge = 1e-6f};
        const Variation by = variation(tree, rgb, settings, ctx);
        const auto &found = by.gradient, &metrics = by.upper;
        float length = 0;
        for (const float s : slope) length += s * s;
        length = std::sqrt(length);
        for (size_t i = 0; i < tree.size(); ++i) {
            for (size_t k = 0; k < 3 * axes; ++k) ASSERT_NEAR(found[3 * axes * i + k], slope[k % axes], 1e-5f) << axes;
            double product, ratio, along = 0;
            const auto vector = steepest(&metrics[axes * (axes + 1) / 2 * i], axes, product, ratio);
            for (size_t d = 0; d < axes; ++d) along += vector[d] * double(slope[d] / length);
            EXPECT_NEAR(std::abs(along), 1, 1e-5);
            EXPECT_NEAR(product, 1, 1e-4);
            EXPECT_NEAR(ratio, 0.05, 1e-3);
        }
    }
}

TEST(StructureTensors, WithoutVariationAreEuclidean) {
    PlainContext ctx;
    const PointTree tree = tree_of(random_points(100, 4, 1));
    const std::vector<float> rgb(300, 0.25f);
    const Variation by = variation(tree, rgb, {}, ctx);
    for (const float x : by.gradient) EXPECT_EQ(x, 0);
    for (const auto* bound : {&by.least, &by.most})
        for (const float x : *bound) EXPECT_EQ(x, 0.25f);
    const auto& metrics = by.upper;
    for (size_t i = 0; i < 100; ++i)
        for (size_t a = 0; a < 4; ++a)
            for (size_t b = a; b < 4; ++b) EXPECT_EQ(metrics[10 * i + upper_index(a, b, 4)], a == b ? 1.0f : 0.0f);
}

// A ramp and noise that no axis explains: radiance comes nearer to the ramp by far; of the ramp alone, or of a step, it stays what
// was sampled.
TEST(StructureTensors, TakeNoiseOffRadianceAndLeaveTheRest) {
    PlainContext ctx;
    for (const size_t axes : {2u, 3u, 5u}) {
        const PointTree tree = tree_of(random_points(1500, axes, unsigned(axes)));
        std::mt19937 random(11);
        std::normal_distribution<float> noise(0, 0.2f);
        const auto off = [&](const std::function<float(size_t)>& exact, float part, bool smooth) {
            std::vector<float> rgb;
            for (size_t i = 0; i < tree.size(); ++i) {
                const float value = exact(i) + part * noise(random);
                rgb.insert(rgb.end(), 3, value);
            }
            TensorSettings settings;
            settings.smooth = smooth;
            const Variation by = variation(tree, rgb, settings, ctx);
            if (!smooth) {
                EXPECT_EQ(by.radiance, rgb);
            }
            double sum = 0;
            for (size_t i = 0; i < tree.size(); ++i) sum += std::pow(double(by.radiance[3 * i]) - double(exact(i)), 2) / double(tree.size());
            return std::sqrt(sum);
        };
        const auto ramp = [&](size_t i) { return 0.5f + 0.02f * tree.at(0)[i] - 0.01f * tree.at(1)[i]; };
        const auto step = [&](size_t i) { return tree.at(0)[i] < 8 ? 0.0f : 1.0f; };
        EXPECT_NEAR(off(ramp, 1, false), 0.2, 0.01) << axes;
        EXPECT_LT(off(ramp, 1, true), axes < 5 ? 0.09 : 0.15) << axes;
        EXPECT_LT(off(ramp, 0, true), 1e-5) << axes;
        EXPECT_LT(off(step, 0, true), axes < 5 ? 0.05 : 0.1) << axes;
    }
}

// Samples that see a lamp or not by chance outshine nobody: their noise goes. A lamp in its place keeps its edge within 2 %.
TEST(StructureTensors, TellALampByChanceFromALampInItsPlace) {
    PlainContext ctx;
    for (const size_t axes : {2u, 3u, 4u})
        for (unsigned seed = 0; seed < 4; ++seed) {
            const PointTree tree = tree_of(random_points(2000, axes, unsigned(axes) + 100 * seed));
            std::mt19937 random(seed);
            std::bernoulli_distribution seen(0.3);
            std::vector<float> by_chance, in_place;
            for (size_t i = 0; i < tree.size(); ++i) {
                by_chance.insert(by_chance.end(), 3, seen(random) ? 5.0f : 0.0f);
                in_place.insert(in_place.end(), 3, tree.at(0)[i] < 8 ? 5.0f : 0.0f);
            }
            TensorSettings settings;
            settings.smooth = true;
            const Variation noisy = variation(tree, by_chance, settings, ctx), lamp = variation(tree, in_place, settings, ctx);
            double sum = 0, worst = 0;
            for (size_t i = 0; i < in_place.size(); ++i) {
                sum += std::pow(double(noisy.radiance[i]) - 1.5, 2) / double(in_place.size());
                worst = std::max(worst, std::abs(double(lamp.radiance[i]) - double(in_place[i])));
            }
            EXPECT_LT(std::sqrt(sum), 0.9) << axes << ' ' << seed;  // of 2.3
            EXPECT_LT(worst, 0.1) << axes << ' ' << seed;
        }
}

// A sample's neighbours against a plain search, by distance and by a metric, on each instruction set.
TEST(Neighbourhood, HoldsTheNearest) {
    std::mt19937 random(3);
    std::normal_distribution<double> number;
    for (const size_t axes : {2u, 3u, 5u, 8u}) {
        const auto at = random_points(500, axes, 9);
        SamplesAround around;
        around.size = 500;
        for (size_t d = 0; d < axes; ++d) around.at[d] = at[d], around.at[d].resize(512, 1e18f);
        for (std::uint32_t i = 0; i < 500; ++i) around.place.push_back(i);
        Matrix half{};
        for (size_t a = 0; a < axes; ++a)
            for (size_t b = 0; b < axes; ++b) half[a][b] = number(random);
        std::vector<float> upper;
        for (size_t a = 0; a < axes; ++a)
            for (size_t b = a; b < axes; ++b) {
                double sum = 0;
                for (size_t k = 0; k < axes; ++k) sum += half[k][a] * half[k][b];
                upper.push_back(float(sum));
            }
        const Matrix m = matrix_of(upper.data(), axes);
        for (const bool own : {false, true})
            for (const std::uint32_t i : {0u, 17u, 499u}) {
                std::vector<float> centre;
                std::vector<double> all;
                for (size_t d = 0; d < axes; ++d) centre.push_back(at[d][i]);
                for (size_t j = 0; j < 500; ++j) {
                    double sum = 0;
                    for (size_t a = 0; a < axes; ++a)
                        for (size_t b = 0; b < axes; ++b) sum += (own ? m[a][b] : a == b) * double(at[a][j] - centre[a]) * double(at[b][j] - centre[b]);
                    all.push_back(sum);
                }
                for (const float guess : {0.0f, 1e-3f, 40.0f, 1e9f}) {
                    Neighbourhood found;
                    found.guess = guess;
                    ASSERT_TRUE(WEFT_PICK(find_neighbours)(around, axes, centre.data(), own ? upper.data() : nullptr, 1e9f, 40, found));
                    EXPECT_GE(found.near.size(), 40u);
                    EXPECT_LE(found.near.size(), 46u);
                    // None that is left out is nearer than one that is not.
                    double farthest = 0, nearest = 1e300;
                    for (std::uint32_t j = 0; j < 500; ++j)
                        if (std::find(found.near.begin(), found.near.end(), j) != found.near.end())
                            farthest = std::max(farthest, all[j]);
                        else
                            nearest = std::min(nearest, all[j]);
                    EXPECT_LT(farthest, nearest * (1 + 1e-4));
                    for (size_t k = 0; k < found.near.size(); ++k) EXPECT_NEAR(found.weight[k], std::exp(-2 * all[found.near[k]] / farthest), 1e-4);
                }
                Neighbourhood none;
                EXPECT_FALSE(WEFT_PICK(find_neighbours)(around, axes, centre.data(), nullptr, 1e9f, 501, none));
            }
    }
}

TEST(StructureTensors, AreAlikeOnAllInstructionSets) {
    const SamplerFunction sampler = RunNode("test-sampler").out<SamplerFunction>("sampler");
    const Samples samples = RunNode("uniform-samples").in("sampler", sampler).set("per-pixel", Json(4.0)).out<Samples>("samples");
    const Metrics once = RunNode("structure-tensors").in("samples", samples).out<Metrics>("tensors");
    for (const char* isa : {"v2", "v3", "v4"}) {
        if (isa_named(isa) > best_isa()) continue;
        const Isa before = active_isa();
        pin_isa(*isa_named(isa));
        const Metrics other = RunNode("structure-tensors").in("samples", samples).out<Metrics>("tensors");
        pin_isa(before);
        double off = 0;
        for (size_t i = 0; i < once.gradient.size(); ++i) off += std::abs(double(once.gradient[i]) - double(other.gradient[i])) / double(once.gradient.size());
        EXPECT_LT(off, 1e-3) << isa;
    }
}

// A plain search of all samples, by the words of the definition.
TEST(AnisotropicReconstruct, TakesTheLeastDistanceAmongTheNearest) {
    PlainContext ctx;
    for (const size_t axes : {2u, 3u, 5u, 6u}) {
        const auto at = random_points(900, axes, unsigned(axes) + 20);
        Metrics metrics;
        metrics.space.axes.resize(axes);
        auto tree = std::make_shared<const PointTree>(tree_of(at));
        std::vector<float> rgb;
        for (size_t i = 0; i < tree->size(); ++i) rgb.insert(rgb.end(), 3, std::sin(tree->at(0)[i] - 2 * tree->at(axes - 1)[i]));
        const Variation by = variation(*tree, rgb, {}, ctx);
        metrics.upper = by.upper;
        metrics.tree = tree;
        const auto queries = random_points(60, axes, 5);
        NearSamples near;
        LeastDistance scratch;
        NearbySamples nearby;
        CountingSamples counting;
        Places places;
        NearestSamples nearest;
        for (size_t q = 0; q < 60; ++q) {
            std::vector<float> p;
            for (const auto& axis : queries) p.push_back(axis[q]);
            std::vector<PointTree::Near> found;
            tree->nearest(p.data(), 12, found);
            double least = 1e300;
            std::uint32_t best = 0;
            for (const auto& f : found) {
                const Matrix m = matrix_of(&metrics.upper[metrics.numbers() * f.place], axes);
                double sum = 0;
                for (size_t a = 0; a < axes; ++a)
                    for (size_t b = 0; b < axes; ++b) sum += m[a][b] * double(p[a] - tree->at(a)[f.place]) * double(p[b] - tree->at(b)[f.place]);
                if (sum < least) least = sum, best = f.place;
            }
            std::vector<std::pair<double, std::uint32_t>> ordered;
            // And the four of least distance of those that count there.
            metrics.supports = by.supports;
            for (std::uint32_t j = 0; j < tree->size(); ++j) {
                const Matrix m = matrix_of(&metrics.upper[metrics.numbers() * j], axes);
                double sum = 0, off2 = 0;
                for (size_t a = 0; a < axes; ++a) {
                    off2 += std::pow(double(p[a] - tree->at(a)[j]), 2);
                    for (size_t b = 0; b < axes; ++b) sum += m[a][b] * double(p[a] - tree->at(a)[j]) * double(p[b] - tree->at(b)[j]);
                }
                if (off2 <= double(by.supports.squared[j])) ordered.emplace_back(sum, j);
            }
            std::sort(ordered.begin(), ordered.end());
            // Among other places, of a box of its own, a larger one, or one of x and y alone.
            for (const auto& [side, wide] : {std::pair(0.0f, axes), std::pair(2.0f, axes), std::pair(2.0f, size_t(2))}) {
                std::vector<float> lo = p, hi = p;
                for (size_t d = 0; d < wide; ++d) lo[d] -= side, hi[d] += side;
                gather(metrics, lo.data(), hi.data(), nearby);
                WEFT_PICK(find_counting)(nearby, metrics.upper.data(), lo.data(), hi.data(), counting);
                places.start(axes, 19);
                for (size_t d = 0; d < axes; ++d) {
                    std::fill(places.at[d].begin(), places.at[d].end(), lo[d]);
                    places.at[d][q % 19] = p[d];
                }
                places.pad();
                WEFT_PICK(nearest_by_metric)(counting, places, nearest);
                for (size_t k = 0; k < NearestSamples::most; ++k) {
                    const float distance2 = nearest.distance2[k][q % 19];
                    ASSERT_EQ(distance2 < NearestSamples::none, k < ordered.size()) << axes;
                    if (k < ordered.size()) {
                        EXPECT_EQ(counting.place[nearest.sample[k][q % 19]], ordered[k].second);
                    }
                }
            }
            // However far it looks, from all there are down to where too few are left.
            for (const float reach : {100.0f, std::sqrt(found.back().distance2) * 1.001f, std::sqrt(found.back().distance2) * 0.9f}) {
                const bool all = gather(metrics, {p[0] - 1, p[1] - 1, p[0] + 1, p[1] + 1}, p.data(), reach, near);
                const std::int32_t winner = WEFT_PICK(least_distance)(near, p[0], p[1], 12, all ? 1e29f : reach * reach, scratch);
                if (reach * reach < found.back().distance2) {
                    EXPECT_EQ(winner, not_known);
                } else {
                    ASSERT_NE(winner, not_known);
                    EXPECT_EQ(near.place[size_t(winner)], best);
                }
            }
        }
    }
}

std::string graph(const std::string& function, const std::string& more, const std::string& samples, const std::string& tensors = "", const std::string& reconstruct = "") {
    return R"({"weft": 1, "nodes": {
        "sampler": {"type": "test-sampler", "set": {"function": ")" + function + R"(")" + more + R"(}},
        "boxes": {"type": "adaptive-samples", "in": {"sampler": "sampler"}, "set": {"budget": 4)" + samples + R"(}},
        "ways": {"type": "structure-tensors", "in": {"samples": "boxes.samples", "leaves": "boxes.leaves"}, "set": {)" + tensors + R"(}},
        "places": {"type": "output-locations", "in": {"samples": "boxes.samples"}, "set": {"per-pixel": 64}},
        "colors": {"type": "anisotropic-reconstruct", "in": {"locations": "places", "samples": "boxes.samples", "tensors": "ways"}, "set": {)" + reconstruct + R"(}},
        "picture": {"type": "accumulate", "in": {"colors": "colors", "locations": "places"}},
        "write": {"type": "write-image", "in": {"image": "picture"}, "set": {"file": "OUT", "depth": "float"}}}})";
}
Image even(const std::string& function, const std::string& more, int per_pixel) {
    GraphRun run(R"({"weft": 1, "nodes": {
        "sampler": {"type": "test-sampler", "set": {"function": ")" + function + R"(")" + more + R"(}},
        "many": {"type": "uniform-samples", "in": {"sampler": "sampler"}, "set": {"seed": 9, "per-pixel": )" + std::to_string(per_pixel) + R"(}},
        "picture": {"type": "pixel-filter", "in": {"samples": "many"}},
        "write": {"type": "write-image", "in": {"image": "picture"}, "set": {"file": "OUT", "depth": "float"}}}})");
    return run.picture;
}
double rmse(const Image& a, const Image& b) {
    double sum = 0;
    EXPECT_EQ(a.pixels().size(), b.pixels().size());
    for (size_t i = 0; i < a.pixels().size(); ++i) sum += std::pow(double(a.pixels()[i]) - double(b.pixels()[i]), 2);
    return std::sqrt(sum / double(a.pixels().size()));
}

TEST(AnisotropicReconstruct, OfAConstantIsThatConstant) {
    for (const char* blend : {R"("blend": "nearest")", R"("blend": "tent")", R"("blend": "linear")"}) {
        GraphRun run(graph("constant", R"(, "width": 20, "height": 17)", "", "", blend));
        for (const float x : run.picture.pixels()) EXPECT_EQ(x, 0.5f);
    }
}

TEST(AnisotropicReconstruct, OfAMovingDiscIsNearTheTruth) {
    const Image reference = even("disc", "", 2048);
    const double plain = rmse(even("disc", "", 4), reference);
    for (const int seed : {1, 2, 3}) {
        GraphRun run(graph("disc", "", R"(, "seed": )" + std::to_string(seed)));
        EXPECT_LT(rmse(run.picture, reference), 0.2 * plain) << seed;
    }
}

// Over black a disc is at a point for as long as its chord takes to pass: no pixel, no filter.
TEST(AnisotropicRadiance, OfAMovingDiscAtAPointIsItsChord) {
    SamplerFunction sampler = RunNode("test-sampler").out<SamplerFunction>("sampler");
    sampler.evaluate = [](const SamplerPoints& points, std::uint64_t, std::span<float> rgb) {
        for (size_t i = 0; i < points.size(); ++i) {
            const float x = 48 * points.axes[0][i], y = 48 * points.axes[1][i], t = points.axes[2][i];
            std::fill_n(&rgb[3 * i], 3, std::hypot(x - 10 - 28 * t, y - 24) < 9 ? 1.0f : 0.0f);
        }
    };
    Samples samples;
    LeafTree leaves;
    RunNode node("adaptive-samples");
    node.in("sampler", sampler).set("budget", Json(8.0));
    node.run({Slot{"samples", &type_info<Samples>(), &samples, {}}, Slot{"leaves", &type_info<LeafTree>(), &leaves, {}}});
    const Metrics metrics = RunNode("structure-tensors").in("samples", samples).in("leaves", leaves).out<Metrics>("tensors");
    const AnisotropicRadiance radiance(metrics, samples.rgb().data(), 12, Blend::linear);
    EXPECT_NEAR(2 * std::sqrt(81.0) / 28, .6428571, 1e-7);
    for (const float y : {24.0f, 28.0f, 31.0f}) {
        constexpr size_t times = 512;
        double mean = 0;
        for (const float x : {22.0f, 24.0f, 26.0f}) {
            Places places;
            places.start(3, times);
            for (size_t i = 0; i < times; ++i) places.at[0][i] = x, places.at[1][i] = y, places.at[2][i] = 28 * (float(i) + 0.5f) / times;
            AnisotropicRadiance::Scratch scratch;
            std::array<float, most_axes> lo{}, hi{};
            places.bounds(lo.data(), hi.data());
            radiance.prepare(lo.data(), hi.data(), scratch);
            std::vector<float> rgb(3 * times);
            radiance.at(places, scratch, [&](size_t i) { return &rgb[3 * i]; });
            for (size_t i = 0; i < times; ++i) mean += double(rgb[3 * i]) / (3 * times);
        }
        EXPECT_NEAR(mean, 2 * std::sqrt(81 - std::pow(double(y) - 24, 2)) / 28, 0.02) << y;
    }
}

// A step along a diagonal of x and t: distances of their own pay, and are short along it.
TEST(AnisotropicReconstruct, OfAMovingStepBeatsThePlainNearest) {
    const std::string step = R"(, "speed": 28)";
    const Image reference = even("edge", step, 2048);
    GraphRun own(graph("edge", step, "")), plain(graph("edge", step, "", R"("floor": 1)"));
    EXPECT_LE(rmse(own.picture, reference), 0.8 * rmse(plain.picture, reference));
}

TEST(StructureTensors, FindTheWayAStepMoves) {
    const SamplerFunction sampler = RunNode("test-sampler").set("function", Json("edge")).set("speed", Json(28.0)).out<SamplerFunction>("sampler");
    Samples samples;
    LeafTree leaves;
    RunNode node("adaptive-samples");
    node.in("sampler", sampler).set("budget", Json(4.0));
    node.run({Slot{"samples", &type_info<Samples>(), &samples, {}}, Slot{"leaves", &type_info<LeafTree>(), &leaves, {}}});
    const Metrics metrics = RunNode("structure-tensors").in("samples", samples).in("leaves", leaves).out<Metrics>("tensors");
    ASSERT_EQ(metrics.space.extent[2], 28);
    std::vector<double> off;
    for (size_t i = 0; i < metrics.size(); ++i) {
        const float x = metrics.tree->at(0)[i], t = metrics.tree->at(2)[i] / 28;
        if (std::abs(x - (12 + 28 * t)) > 1 || x < 3 || x > 45 || t < 0.1f || t > 0.9f) continue;
        double product, ratio;
        const auto v = steepest(&metrics.upper[metrics.numbers() * i], 3, product, ratio);
        off.push_back(std::acos(std::min(1.0, std::abs(v[0] - v[2]) / std::sqrt(2.0))) * 180 / std::numbers::pi);
    }
    ASSERT_GT(off.size(), 500u);
    std::sort(off.begin(), off.end());
    EXPECT_LT(off[off.size() / 2], 5) << "degrees, median of " << off.size();
}

TEST(AnisotropicReconstruct, IsTheSameForAnyTilesAndThreads) {
    for (const char* blend : {R"("blend": "nearest")", R"("blend": "tent")", R"("blend": "linear")"}) {
        const std::string text = graph("disc", "", "", "", blend);
        const auto once = values_of(GraphRun(text, 32, 1).picture);
        EXPECT_EQ(values_of(GraphRun(text, 8, 3).picture), once);
        EXPECT_EQ(values_of(GraphRun(text, 13, 16).picture), once);
    }
}

TEST(AnisotropicReconstruct, SaysWhatIsMissing) {
    Samples none;
    none.width = none.height = 4;
    none.spp = 1;
    EXPECT_NE(error_of([&] { RunNode("structure-tensors").in("samples", none).out<Metrics>("tensors"); }).find("needs xy"), std::string::npos);
    const SamplerFunction sampler = RunNode("test-sampler").out<SamplerFunction>("sampler");
    const Samples samples = RunNode("uniform-samples").in("sampler", sampler).set("per-pixel", Json(1.0)).out<Samples>("samples");
    LeafTree leaves;
    leaves.axes = {"x", "y", "bounce-u"};
    leaves.extent = {48, 48, 16};
    EXPECT_NE(error_of([&] { RunNode("structure-tensors").in("samples", samples).in("leaves", leaves).out<Metrics>("tensors"); }).find("needs bounce_u for axis bounce-u"),
              std::string::npos);
}

}  // namespace
}  // namespace weft
