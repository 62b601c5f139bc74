// Random parameter filtering as graphs run it: what is noise goes, what is signal stays, whatever
// the samples are.
#include <gtest/gtest-spi.h>

#include <filesystem>
#include <limits>
#include <set>

#include "image/measures.h"
#include "samples/file_bytes.h"
#include "samples/sample_file.h"
#include "samples/write_npz.h"
#include "tests/graph_run.h"
#include "tests/mapped_bytes.h"
#include "tests/rpf/rpf_test.h"

namespace weft {
namespace {

// A graph that filters a file's samples by `nodes`, the last of which is called `filtered`.
std::string filter_text(const std::string& file, const std::string& nodes) {
    return R"({"weft": 1, "nodes": {
        "samples": {"type": "read-samples", "set": {"file": ")" +
           file + R"(", "channels": ["*"]}},)" + nodes + R"(,
        "picture": {"type": "pixel-filter", "in": {"samples": "filtered"}},
        "write":   {"type": "write-image", "in": {"image": "picture"}, "set": {"file": "OUT", "depth": "float"}}}})";
}
// Smoother than the preset is by itself, which keeps pictures crisp.
const std::string weft_preset =
    R"("filtered": {"type": "parts/rpf-weft.json", "in": {"samples": "samples"}, "set": {"sigma": 3, "slope": 4}})";

// One pass of these settings of its nodes.
std::string pass(const std::string& neighbourhoods, const std::string& weights,
                 const std::string& filter, const std::string& outliers) {
    return R"("vectors": {"type": "build-vectors", "in": {"samples": "samples"}},
        "around": {"type": "neighbourhoods", "in": {"vectors": "vectors"}, "set": {)" +
           neighbourhoods + R"(}},
        "weights": {)" +
           weights + R"(, "in": {"neighbourhoods": "around"}},
        "filter": {)" +
           filter + R"(, "in": {"neighbourhoods": "around", "weights": "weights"}},
        "outliers": {"type": "clamp-outliers", "in": {"colors": "filter"}, "set": {)" +
           outliers + R"(}},
        "filtered": {"type": "collect-samples", "in": {"colors": "outliers", "samples": "samples"}})";
}

std::string saved(const TestFolder& folder, const Samples& samples) {
    PlainContext ctx;
    const std::string path = folder / "samples.npz";
    write_npz(samples, path, false, ctx);
    return path;
}
Image filtered(const Samples& samples, const std::string& nodes, int tile = 32, int threads = 1) {
    const TestFolder folder;
    return GraphRun(filter_text(saved(folder, samples), nodes), tile, threads).picture;
}

float grey(const Drawn&) {
    return 0.5f;
}
double mean_of(const Image& image) {
    double sum = 0;
    for (const float v : image.pixels()) sum += double(v);
    return sum / double(image.pixels().size());
}
// Root mean square of what red differs from `exact` by, away from the edges.
double rms_of(const Image& image, const std::function<double(int, int)>& exact) {
    double sum = 0, n = 0;
    for (int y = 2; y < image.height() - 2; ++y)
        for (int x = 2; x < image.width() - 2; ++x, n += 1)
            sum += std::pow(double(image.at(x, y)[0]) - exact(x, y), 2);
    return std::sqrt(sum / n);
}

TEST(Rpf, noise_of_the_light_goes_and_the_mean_stays) {
    const Samples samples = feature_samples(
        40, 30, 8, [](const Drawn& d) { return 2 * d.l; }, grey);
    const Image image = filtered(samples, weft_preset);
    const double unfiltered = 2 / std::sqrt(12.0) / std::sqrt(8.0);
    EXPECT_LT(rms_of(image, [](int, int) { return 1.0; }), unfiltered / 3);
    EXPECT_NEAR(mean_of(image), (1 + 0.5 + 0.25) / 3, 0.01);
}

TEST(Rpf, edges_that_features_show_stay_sharp) {
    const auto half = [](const Drawn& d) { return d.x >= 20 ? 1.0f : 0.0f; };
    const Samples samples = feature_samples(
        40, 30, 8, [&](const Drawn& d) { return (0.1f + half(d)) * 2 * d.l; },
        [&](const Drawn& d) { return 0.1f + 0.8f * half(d); });
    const Image image = filtered(samples, weft_preset);
    for (int y = 5; y < 25; ++y) {
        EXPECT_NEAR(image.at(19, y)[0], 0.1f, 0.03f);
        EXPECT_NEAR(image.at(20, y)[0], 1.1f, 0.3f);
    }
}

TEST(Rpf, edges_that_no_feature_shows_stay_where_the_samples_show_them) {
    // A shadow's edge under a light that is half hidden: the colours alone have it.
    const Samples samples = feature_samples(
        40, 30, 8, [](const Drawn& d) { return d.x >= 20 ? 1 + 0.2f * d.l : 0.1f + 0.02f * d.l; },
        grey);
    const Image image = filtered(samples, weft_preset);
    for (int y = 5; y < 25; ++y) {
        EXPECT_LT(image.at(18, y)[0], 0.2f);
        EXPECT_GT(image.at(21, y)[0], 1.0f);
    }
}

TEST(Rpf, a_constant_is_that_constant_by_every_preset) {
    const Samples samples = feature_samples(
        20, 14, 4, grey, [](const Drawn& d) { return d.x > 9 ? 0.2f : 0.7f + 0.1f * d.u; });
    for (const char* preset : {"weft", "release", "report"}) {
        const Image image =
            filtered(samples, std::string(R"("filtered": {"type": "parts/rpf-)") + preset +
                                  R"(.json", "in": {"samples": "samples"}})");
        for (int y = 0; y < 14; ++y)
            for (int x = 0; x < 20; ++x) EXPECT_NEAR(image.at(x, y)[0], 0.5f, 1e-5f) << preset;
    }
}

TEST(Rpf, few_samples_and_pictures_of_one_pixel_work) {
    const auto noisy = [](const Drawn& d) { return 2 * d.l; };
    for (const char* preset : {"weft", "release", "report"}) {
        const std::string nodes = std::string(R"("filtered": {"type": "parts/rpf-)") + preset +
                                  R"(.json", "in": {"samples": "samples"}})";
        for (const auto& [width, height, spp] : {std::array{16, 12, 1}, std::array{16, 12, 2},
                                                 std::array{1, 1, 8}, std::array{1, 9, 3}}) {
            const Image image = filtered(feature_samples(width, height, spp, noisy, grey), nodes);
            for (const float v : image.pixels())
                EXPECT_TRUE(std::isfinite(v))
                    << preset << " " << width << " x " << height << " x " << spp;
        }
    }
}

TEST(Rpf, one_sample_a_pixel_is_better_than_none_filtered) {
    const Samples samples = feature_samples(
        40, 30, 1, [](const Drawn& d) { return 2 * d.l; }, grey);
    EXPECT_LT(rms_of(filtered(samples, weft_preset), [](int, int) { return 1.0; }),
              0.5 * 2 / std::sqrt(12.0));
}

TEST(Rpf, samples_without_features_are_filtered_by_their_colours) {
    Samples samples = feature_samples(
        30, 20, 8, [](const Drawn& d) { return 2 * d.l; }, grey);
    std::erase_if(samples.channels,
                  [](const Channel& c) { return c.name != "xy" && c.name != "rgb"; });
    EXPECT_LT(rms_of(filtered(samples, weft_preset), [](int, int) { return 1.0; }),
              2 / std::sqrt(12.0) / std::sqrt(8.0) / 3);
}

TEST(Rpf, gives_the_same_bits_for_any_tiles_and_threads) {
    const Samples samples = feature_samples(
        37, 29, 4, [](const Drawn& d) { return d.x > 18 ? d.l : 0.2f + 0.1f * d.u; },
        [](const Drawn& d) { return d.x > 18 ? 0.9f : 0.2f; });
    const std::string blocks =
        pass(R"("box": 9, "block": 3, "cluster": true)", R"("type": "dependency-estimate")",
             R"("type": "bilateral-filter")", R"("rule": "joint")");
    for (const std::string& nodes : {weft_preset, blocks}) {
        const std::vector<float> one = values_of(filtered(samples, nodes));
        for (const auto& [tile, threads] : {std::pair{8, 1}, std::pair{13, 2}, std::pair{64, 7}})
            EXPECT_EQ(values_of(filtered(samples, nodes, tile, threads)), one) << tile;
    }
}

TEST(BilateralFilter, without_weights_is_the_mean_and_with_large_ones_nothing) {
    const Samples samples = feature_samples(
        12, 12, 4, [](const Drawn& d) { return d.l; }, [](const Drawn& d) { return d.v; });
    const auto by = [&](const char* weights) {
        return filtered(samples,
                        pass(R"("box": 31, "fraction": 8, "cluster": false)",
                             std::string(R"("type": "constant-weights", "set": {)") + weights + "}",
                             R"("type": "bilateral-filter")", R"("rule": "none")"));
    };
    const Image none = by(R"("alpha": 0, "beta": 0)"), large = by(R"("alpha": 1e5, "beta": 1e5)");
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 12; ++x) {
            EXPECT_NEAR(none.at(x, y)[0], 0.5f, 0.06f);
            float own = 0;
            for (size_t i = 0; i < 4; ++i)
                own += samples.rgb()[3 * (4 * (size_t(y) * 12 + size_t(x)) + i)] / 4;
            EXPECT_NEAR(large.at(x, y)[0], own, 1e-5f);
        }
}

TEST(DependencyEstimate, tells_noise_from_position) {
    // Filtered without likeness of colours where colours are noise; kept where they depend on
    // position.
    const auto spread = [](const Color& color) {
        const Samples samples = feature_samples(24, 24, 8, color, grey);
        const Image image = filtered(
            samples,
            pass(R"("box": 15, "cluster": false)",
                 R"("type": "dependency-estimate", "set": {"combine": "largest"})",
                 R"("type": "bilateral-filter", "set": {"variance": 0.2})", R"("rule": "none")"));
        double sum = 0, squares = 0, n = 0;
        for (int y = 8; y < 16; ++y)
            for (int x = 8; x < 16; ++x, n += 1)
                sum += image.at(x, y)[0], squares += std::pow(image.at(x, y)[0], 2);
        return std::sqrt(std::max(0.0, squares / n - sum * sum / n / n));
    };
    EXPECT_LT(spread([](const Drawn& d) { return d.l; }), 0.03);
    EXPECT_GT(spread([](const Drawn& d) { return d.x / 24; }), 0.07);  // 8 pixels of 1/24: 0.095
}

TEST(ClampOutliers, keeps_a_pixels_light_where_asked_to) {
    // One sample in eight of each fourth pixel is fifty times as bright.
    Samples samples = feature_samples(12, 12, 8, grey, grey);
    std::vector<float> rgb(samples.rgb().begin(), samples.rgb().end());
    for (size_t p = 0; p < 144; p += 4)
        for (size_t c = 0; c < 3; ++c) rgb[3 * (8 * p + 3) + c] *= 50;
    samples.add("rgb", 3, rgb);
    const auto by = [&](const char* rule) {
        return mean_of(filtered(
            samples, pass(R"("box": 3)", R"("type": "constant-weights", "set": {"alpha": 1e5})",
                          R"("type": "bilateral-filter")", rule)));
    };
    const double all = by(R"("rule": "none")");
    for (const char* rule : {R"("rule": "joint")", R"("rule": "mean")", R"("rule": "upper")"})
        EXPECT_NEAR(by(rule) / all, 1, 1e-3) << rule;
    EXPECT_LT(by(R"("rule": "upper", "keep-energy": false)"), 0.8 * all);
}

TEST(Draws, stratified_places_are_distinct_and_spread_as_asked) {
    rpf::DrawSettings by{rpf::DrawRule::stratified, 31, 600, 5.0f, 8, 3};
    const auto places = rpf::make_places(by).offsets;
    ASSERT_EQ(places.size(), 600u);
    std::set<std::tuple<int, int, unsigned>> seen;
    double squares = 0;
    for (const auto& p : places) {
        EXPECT_TRUE(seen.insert({p.dx, p.dy, p.turn}).second);
        EXPECT_TRUE(p.dx != 0 || p.dy != 0);
        EXPECT_LT(p.turn, 8u);
        squares += p.dx * p.dx + p.dy * p.dy;
    }
    EXPECT_NEAR(std::sqrt(squares / 600 / 2), 5.0, 0.8);
}

TEST(Draws, never_give_the_blocks_own_nor_twice_the_same_but_where_independent) {
    const Samples samples = feature_samples(20, 20, 4, grey, grey);
    for (const rpf::DrawRule rule :
         {rpf::DrawRule::stratified, rpf::DrawRule::distinct, rpf::DrawRule::gaussian}) {
        const rpf::DrawSettings by{rule, 15, 300, 3.5f, 4, 7};
        const auto places = rpf::make_places(by);
        rpf::DrawScratch scratch;
        for (const PixelBlock block :
             {PixelBlock{0, 0, 2, 2}, PixelBlock{9, 9, 10, 10}, PixelBlock{19, 19, 20, 20}}) {
            rpf::DrawnSamples found;
            rpf::draw(samples, by, places, block, {}, scratch, found);
            const std::vector<std::uint32_t>& drawn = found.sample;
            EXPECT_GT(drawn.size(), 40u);
            std::set<std::uint32_t> distinct(drawn.begin(), drawn.end());
            EXPECT_TRUE(rule == rpf::DrawRule::gaussian || distinct.size() == drawn.size());
            for (const std::uint32_t i : drawn) {
                const int pixel = int(i / 4), x = pixel % 20, y = pixel / 20;
                EXPECT_FALSE(x >= block.x0 && x < block.x1 && y >= block.y0 && y < block.y1);
                EXPECT_LE(std::abs(x - (block.x0 + block.x1 - 1) / 2), 7);
            }
        }
    }
}

TEST(BuildVectors, leaves_out_what_never_changes_and_counts_what_is_not_finite) {
    Samples samples = feature_samples(6, 5, 2, grey, grey);
    samples.add("albedo2", 3, std::vector<float>(3 * samples.size(), 0.0f));
    std::vector<float> normal(samples.values("normal").begin(), samples.values("normal").end());
    normal[3 * 17 + 1] = std::numeric_limits<float>::quiet_NaN();
    samples.add("normal", 3, normal);
    RunNode node("build-vectors");
    const SampleVectors v = node.in("samples", samples).out<SampleVectors>("vectors");
    EXPECT_EQ(std::count(v.channels.begin(), v.channels.end(), "albedo2"), 0);
    EXPECT_EQ(std::count(v.channels.begin(), v.channels.end(), "light_uv"), 1);
    EXPECT_FALSE(v.is_whole(17));
    EXPECT_TRUE(v.is_whole(16));
    // Whole vectors are read of the last record too, and what they hold is compared.
    ASSERT_GE(v.values.size(), v.size() * v.stride() + SampleVectors::padding);
    EXPECT_TRUE(std::all_of(v.values.begin() + std::ptrdiff_t(v.size() * v.stride()),
                            v.values.end(), [](float x) { return x == 0; }));
    ASSERT_EQ(node.ctx.warnings.size(), 1u);
    EXPECT_NE(node.ctx.warnings[0].find("1 of 60 samples"), std::string::npos)
        << node.ctx.warnings[0];
    EXPECT_NE(error_of([&] {
                  RunNode("build-vectors")
                      .set("features", Json::list({Json("colour")}))
                      .in("samples", samples)
                      .run();
              }).find("colour"),
              std::string::npos);
}

TEST(BuildVectors, knows_between_what_pixels_are_where_all_is_finite) {
    Samples samples = feature_samples(6, 5, 4, grey, grey);
    const auto bounds = [&] {
        return RunNode("build-vectors").in("samples", samples).out<SampleVectors>("vectors").bounds;
    };
    EXPECT_EQ(bounds().scales.size(), 6u);  // position and normal
    std::vector<float> normal(samples.values("normal").begin(), samples.values("normal").end());
    normal[3 * 17 + 1] = std::numeric_limits<float>::infinity();
    samples.add("normal", 3, normal);
    EXPECT_TRUE(bounds().empty());
    samples = feature_samples(6, 5, 3, grey, grey);
    EXPECT_TRUE(bounds().empty());
}

TEST(BuildVectors, of_a_mapped_file_lets_go_of_what_only_they_are_made_of) {
    if (mapped_bytes() < 0) GTEST_SKIP() << "no RssFile in /proc/self/status";
    const Samples samples = feature_samples(320, 200, 8, grey, grey);
    const SampleVectors expected =
        RunNode("build-vectors").in("samples", samples).out<SampleVectors>("vectors");
    const TestFolder folder;
    PlainContext ctx;
    const Samples mapped =
        read_sample_file(map_file(saved(folder, samples)), {.channels = {"*"}}, ctx);
    const double before = mapped_bytes();
    const SampleVectors v =
        RunNode("build-vectors").in("samples", mapped).out<SampleVectors>("vectors");
    size_t numbers = 0;  // but for x, y, r, g, b
    for (const auto& component : v.components) numbers += component.role != Role::position;
    EXPECT_LT(mapped_bytes() - before, -0.8 * 4 * double(numbers * samples.size()));
    EXPECT_TRUE(std::equal(v.values.begin(), v.values.end(), expected.values.begin(),
                           expected.values.end()));
    EXPECT_TRUE(std::equal(mapped.values("normal").begin(), mapped.values("normal").end(),
                           samples.values("normal").begin(), samples.values("normal").end()));
}

TEST(BilateralFilterPixels, says_what_it_misses) {
    static const TestFolder folder;
    static const std::string text = filter_text(
        saved(folder, feature_samples(6, 5, 2, grey, grey)),
        R"("vectors": {"type": "build-vectors", "in": {"samples": "samples"}, "set": {"pixels": false}},
        "around": {"type": "neighbourhoods", "in": {"vectors": "vectors"}},
        "weights": {"type": "constant-weights", "in": {"neighbourhoods": "around"}},
        "filter": {"type": "bilateral-filter-pixels", "in": {"neighbourhoods": "around", "weights": "weights"}},
        "filtered": {"type": "collect-samples", "in": {"colors": "filter", "samples": "samples"}})");
    EXPECT_NONFATAL_FAILURE(GraphRun{text}, "set 'pixels' of 'build-vectors' to true");
}

TEST(RecentreSamples, puts_samples_where_the_lens_centre_sees_them_and_back) {
    Samples samples = feature_samples(
        16, 12, 3, [](const Drawn& d) { return d.l; }, grey);
    samples.lens = Lens{};
    samples.lens->c0 = 8;
    samples.lens->c1 = 1;  // of depth 4: 3 px a unit of lens
    const Samples moved =
        RunNode("recentre-samples").in("samples", samples).out<Samples>("samples");
    ASSERT_EQ(moved.size(), samples.size());
    const Channel* source = moved.find("source_sample");
    ASSERT_TRUE(source && source->whole());
    for (size_t p = 0; p < moved.pixels(); ++p)
        for (size_t i = moved.of_pixel(p).begin; i < moved.of_pixel(p).end; ++i) {
            const size_t from = source->ids[i];
            for (size_t k = 0; k < 2; ++k)
                EXPECT_NEAR(moved.xy()[2 * i + k],
                            samples.xy()[2 * from + k] - 3 * samples.uv()[2 * from + k], 1e-4f);
            EXPECT_EQ(moved.values("albedo")[3 * i], samples.values("albedo")[3 * from]);
            const auto x = std::clamp(int(std::floor(moved.xy()[2 * i])), 0, 15),
                       y = std::clamp(int(std::floor(moved.xy()[2 * i + 1])), 0, 11);
            EXPECT_EQ(p, size_t(y) * 16 + size_t(x));
        }
    EXPECT_FALSE(moved.has_lens());
    const Samples back = RunNode("return-samples")
                             .in("samples", samples)
                             .in("recentred", moved)
                             .out<Samples>("samples");
    EXPECT_TRUE(std::equal(back.rgb().begin(), back.rgb().end(), samples.rgb().begin()));
    EXPECT_NE(error_of([&] {
                  RunNode("return-samples").in("samples", samples).in("recentred", samples).run();
              }),
              "");
}

TEST(RecentreSamples, carries_only_the_channels_that_are_asked_for) {
    const auto grey = [](const Drawn&) { return 0.5f; };
    Samples samples = feature_samples(4, 4, 2, grey, grey);
    samples.add("mark", 1, std::vector<float>(samples.size(), 7));
    const auto recentred = [&](const std::vector<std::string>& channels) {
        Json list = Json::list();
        for (const std::string& name : channels) list.items.push_back(name);
        return RunNode("recentre-samples")
            .in("samples", samples)
            .set("channels", list)
            .out<Samples>("samples");
    };
    const Samples some = recentred({"albedo"}), all = recentred({});
    EXPECT_NE(some.find("albedo"), nullptr);
    EXPECT_FALSE(some.rgb().empty());
    EXPECT_EQ(some.find("mark"), nullptr);
    EXPECT_NE(all.find("mark"), nullptr);
}

TEST(BlendImages, takes_either_picture_at_the_ends) {
    Image low(3, 1, 3), high(3, 1, 3), by(3, 1, 1);
    for (int x = 0; x < 3; ++x)
        for (int c = 0; c < 3; ++c) low.at(x, 0)[c] = 1, high.at(x, 0)[c] = 3;
    high.at(0, 0)[1] = std::numeric_limits<float>::infinity();
    for (int x = 0; x < 3; ++x) *by.at(x, 0) = 0.5f * float(x);
    const Image out =
        RunNode("blend-images").in("low", low).in("high", high).in("by", by).out<Image>("image");
    EXPECT_EQ(out.at(0, 0)[1], 1.0f);
    EXPECT_EQ(out.at(1, 0)[0], 2.0f);
    EXPECT_EQ(out.at(2, 0)[0], 3.0f);
    EXPECT_NE(
        error_of([&] {
            RunNode("blend-images").in("low", low).in("high", Image(2, 1, 3)).in("by", by).run();
        }),
        "");
}

TEST(BlendImages, may_go_from_one_to_the_other_straight) {
    Image low(3, 1, 1), high(3, 1, 1), by(3, 1, 1);
    for (int x = 0; x < 3; ++x)
        *low.at(x, 0) = 2, *high.at(x, 0) = 4, *by.at(x, 0) = 0.25f * float(x + 1);
    const auto blend = [&](const char* step) {
        return RunNode("blend-images")
            .in("low", low)
            .in("high", high)
            .in("by", by)
            .set("step", std::string(step))
            .out<Image>("image");
    };
    for (int x = 0; x < 3; ++x) EXPECT_EQ(*blend("linear").at(x, 0), 2 + 0.5f * float(x + 1));
    EXPECT_LT(*blend("smooth").at(0, 0), 2.5f);
}

class RealSamplesByRpf : public testing::TestWithParam<const char*> {};

TEST_P(RealSamplesByRpf, are_far_closer_to_the_reference_than_their_means) {
    const std::filesystem::path folder =
        std::filesystem::path(WEFT_SOURCE_DIR).parent_path() / "shared" / "data" / GetParam();
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no samples of " << GetParam();
    PlainContext ctx;
    const Image reference = read_picture((folder / "reference.exr").string());
    const auto error = [&](const std::string& nodes) {
        const GraphRun run(filter_text((folder / "s08.npz").string(), nodes), 32, 2);
        return compare_pictures(run.picture, reference, ctx).measures.rel_mse;
    };
    // A box of one pixel holds its own samples only, and without weights they become their mean.
    const double box = error(pass(R"("box": 1, "draws": 1)",
                                  R"("type": "constant-weights", "set": {"alpha": 0, "beta": 0})",
                                  R"("type": "bilateral-filter")", R"("rule": "none")"));
    EXPECT_LT(error(weft_preset), 0.25 * box);
}
INSTANTIATE_TEST_SUITE_P(All, RealSamplesByRpf, testing::Values("killeroos", "buddhas", "bmw"));

}  // namespace
}  // namespace weft
