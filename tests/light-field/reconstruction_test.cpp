// Whole reconstructions of cases with a known answer, and of what is easily lost.
#include "light-field/build_hierarchy_kernel.h"
#include "samples/analytic_scene.h"
#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {

double rms_against_exact(const Image& picture, const char* scene, const AnalyticOptions& options, int border) {
    double sum = 0;
    size_t n = 0;
    for (int y = border; y < options.height - border; ++y)
        for (int x = border; x < options.width - border; ++x)
            if (const auto exact = analytic_exact(scene, options, x, y))
                for (size_t c = 0; c < 3; ++c, ++n) sum += std::pow(double(picture.at(x, y)[c]) - (*exact)[c], 2);
    EXPECT_GT(n, 0u);
    return std::sqrt(sum / double(std::max<size_t>(n, 1)));
}

double rms_of_box(const Samples& s, const char* scene, const AnalyticOptions& options, int border) {
    Image box(s.width, s.height, 3);
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x) {
            const auto range = s.of_pixel(size_t(y) * size_t(s.width) + size_t(x));
            for (size_t i = range.begin; i < range.end; ++i)
                for (int c = 0; c < 3; ++c) box.at(x, y)[c] += s.rgb()[3 * i + size_t(c)] / float(range.end - range.begin);
        }
    return rms_against_exact(box, scene, options, border);
}

// Scene, samples a pixel, most of the box mean's error that may be left.
class KnownScene : public testing::TestWithParam<std::tuple<const char*, int, double>> {};

TEST_P(KnownScene, IsReconstructedFarBetterThanByTheBoxMean) {
    const auto [scene, spp, part] = GetParam();
    PlainContext ctx;
    AnalyticOptions options;
    options.width = 64;
    options.height = 48;
    options.spp = spp;
    const Samples samples = analytic_samples(scene, options, ctx);
    const TestFolder folder;
    const GraphRun run(tlfr_text(saved(folder, samples), R"("per-pixel": 64)"));
    ASSERT_EQ(run.picture.width(), 64);
    EXPECT_LT(rms_against_exact(run.picture, scene, options, 3), part * rms_of_box(samples, scene, options, 3));
}

INSTANTIATE_TEST_SUITE_P(All, KnownScene,
                         testing::Values(std::tuple{"step", 4, 0.6}, std::tuple{"disc", 4, 0.6}, std::tuple{"layers", 4, 0.75},
                                         std::tuple{"plane", 1, 0.9}));

TEST(Reconstruction, OfAConstantIsThatConstant) {
    for (Kind_of kind : {Kind_of::still_pinhole, Kind_of::defocused, Kind_of::moving, Kind_of::moving_in_depth}) {
        Samples s = random_samples(20, 12, 2, kind);
        s.add("rgb", 3, std::vector<float>(3 * s.size(), 0.25f));
        const TestFolder folder;
        const GraphRun run(tlfr_text(saved(folder, s), R"("per-pixel": 16)"));
        for (float value : run.picture.pixels()) EXPECT_NEAR(value, 0.25f, 1e-5f);
    }
}

TEST(Reconstruction, GivesTheSameBitsForAnyTilesAndThreads) {
    const Samples s = random_samples(45, 37, 3, Kind_of::moving_in_depth);
    const TestFolder folder;
    const std::string file = saved(folder, s);
    for (const char* locations : {R"("per-pixel": 12)", R"("per-pixel": 12, "per-slice": 3, "sets": 4)"}) {
        const auto whole = values_of(GraphRun(tlfr_text(file, locations), 64, 1).picture);
        EXPECT_EQ(values_of(GraphRun(tlfr_text(file, locations), 32, 2).picture), whole);
        EXPECT_EQ(values_of(GraphRun(tlfr_text(file, locations), 7, 3).picture), whole);
        EXPECT_EQ(values_of(GraphRun(tlfr_text(file, locations), 1, 7).picture), whole);
    }
}

TEST(Reconstruction, UnderAWideFilterGivesTheSameBitsForAnyTiles) {
    const Samples s = random_samples(30, 20, 2, Kind_of::defocused);
    const TestFolder folder;
    const std::string text = R"({"weft": 1, "nodes": {
        "samples":   {"type": "read-samples", "set": {"file": ")" + saved(folder, s) + R"("}},
        "hierarchy": {"type": "build-hierarchy", "in": {"samples": "samples"}},
        "locations": {"type": "output-locations", "in": {"hierarchy": "hierarchy"}, "set": {"per-pixel": 9}},
        "reproject": {"type": "reproject", "in": {"locations": "locations", "hierarchy": "hierarchy"}},
        "surfaces":  {"type": "same-surface-cluster", "in": {"candidates": "reproject.candidates"}},
        "coverage":  {"type": "nearest-surface", "in": {"candidates": "reproject.candidates", "surfaces": "surfaces", "locations": "locations"}},
        "filter":    {"type": "filter-visible", "in": {"candidates": "reproject.candidates", "surfaces": "surfaces", "visibility": "coverage.visibility"}},
        "picture":   {"type": "accumulate", "in": {"colors": "filter", "locations": "locations"}, "set": {"filter": "mitchell"}},
        "write":     {"type": "write-image", "in": {"image": "picture"}, "set": {"file": "OUT", "depth": "float"}}}})";
    const auto whole = values_of(GraphRun(text, 64, 1).picture);
    EXPECT_EQ(values_of(GraphRun(text, 8, 3).picture), whole);
    EXPECT_EQ(values_of(GraphRun(text, 5, 2).picture), whole);
}

TEST(Reconstruction, IndependentLocationsGiveTheSamePictureUpToNoise) {
    PlainContext ctx;
    AnalyticOptions options;
    options.width = 40;
    options.height = 30;
    options.spp = 4;
    const TestFolder folder;
    const std::string file = saved(folder, analytic_samples("layers", options, ctx));
    const Image shared = GraphRun(tlfr_text(file, R"("per-pixel": 256)")).picture;
    std::string text = tlfr_text(file, R"("per-pixel": 256)");
    const std::string from = "output-locations";
    text.replace(text.find(from), from.size(), "random-locations");
    const Image random = GraphRun(text).picture;
    double sum = 0;
    for (size_t i = 0; i < shared.pixels().size(); ++i) sum += std::pow(double(shared.pixels()[i]) - double(random.pixels()[i]), 2);
    EXPECT_LT(std::sqrt(sum / double(shared.pixels().size())), 0.03);
}

TEST(Reconstruction, FromAPinholeBufferAtFixedTimeIsSharp) {
    // A step in x at pixel 10, seen once a pixel: pixels on either side keep their values.
    Samples s = random_samples(20, 8, 8, Kind_of::still_pinhole);
    std::vector<float> rgb(3 * s.size());
    for (size_t i = 0; i < s.size(); ++i) rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = s.xy()[2 * i] < 10 ? 0.0f : 1.0f;
    s.add("rgb", 3, rgb);
    const TestFolder folder;
    const GraphRun run(tlfr_text(saved(folder, s), R"("per-pixel": 8, "lens": "fixed", "time": "fixed")"));
    for (int y = 0; y < 8; ++y) {
        EXPECT_NEAR(run.picture.at(8, y)[0], 0, 0.02f);
        EXPECT_NEAR(run.picture.at(11, y)[0], 1, 0.02f);
    }
}

TEST(Reconstruction, FindsADefocusedMovingPointFromOutsideTheFrame) {
    // A bright wall, still, in focus; before it, out of focus and moving, an opaque black plane that covers
    // all of the frame at the end of the shutter and was recorded, late, within it only.
    Samples s;
    s.width = 12;
    s.height = 12;
    s.spp = 16;
    s.lens = Lens{-20, 4};  // in focus at 5
    std::mt19937 random(2);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<float> xy, uv, t, z, motion, rgb;
    for (int i = 0; i < 12 * 12 * 16; ++i) {
        const int pixel = i / 16;
        xy.insert(xy.end(), {float(pixel % 12) + unit(random), float(pixel / 12) + unit(random)});
        uv.insert(uv.end(), {0.9f * (2 * unit(random) - 1) * 0.7f, 0.9f * (2 * unit(random) - 1) * 0.7f});
        t.push_back(0.5f + 0.5f * unit(random));
        z.push_back(2.5f);  // slope -4: its disk reaches four pixels
        motion.insert(motion.end(), {2.5f * 30, 0, 0});  // from far left of the frame at t = 0
        rgb.insert(rgb.end(), {0.5f, 0.5f, 0.5f});
    }
    s.set_size(z.size());
    s.add("xy", 2, xy);
    s.add("uv", 2, uv);
    s.add("t", 1, t);
    s.add("z", 1, z);
    s.add("motion", 3, motion);
    s.add("rgb", 3, rgb);
    const TestFolder folder;
    // At t = 0.55 the plane has been carried by up to 14 px either way; pixels at both borders find it.
    const GraphRun run(tlfr_text(saved(folder, s), R"("per-pixel": 32, "time": "fixed", "t": 0.75)"));
    for (int y = 0; y < 12; ++y)
        for (int x : {0, 11}) EXPECT_NEAR(run.picture.at(x, y)[0], 0.5f, 1e-4f);
}

TEST(Reconstruction, FillsHolesWithTheNearestSample) {
    // Samples in the left half of the picture only.
    Samples s = random_samples(24, 10, 1, Kind_of::still_pinhole);
    std::vector<float> xy, z, rgb;
    std::vector<std::uint64_t> first{0};
    for (size_t i = 0; i < s.size(); ++i) {
        if (s.xy()[2 * i] < 12) {
            xy.insert(xy.end(), {s.xy()[2 * i], s.xy()[2 * i + 1]});
            z.push_back(5);
            rgb.insert(rgb.end(), {0.5f, 0.25f, 0.125f});
        }
        first.push_back(z.size());
    }
    Samples half;
    half.width = 24;
    half.height = 10;
    half.spp = 0;
    half.first = Array<std::uint64_t>(first);
    half.set_size(z.size());
    half.add("xy", 2, xy);
    half.add("z", 1, z);
    half.add("rgb", 3, rgb);
    const TestFolder folder;
    const GraphRun run(tlfr_text(saved(folder, half), R"("per-pixel": 4)"));
    for (int x = 0; x < 24; ++x) EXPECT_NEAR(run.picture.at(x, 5)[1], 0.25f, 1e-5f) << x;
}

TEST(Reconstruction, OfOnePixelAndOfNoSample) {
    const TestFolder folder;
    Samples one = random_samples(1, 1, 1, Kind_of::moving_in_depth);
    one.add("rgb", 3, {1, 2, 3});
    const GraphRun run(tlfr_text(saved(folder, one), R"("per-pixel": 4)"));
    ASSERT_EQ(run.picture.width(), 1);
    EXPECT_NEAR(run.picture.at(0, 0)[2], 3, 1e-5f);
}

TEST(Reconstruction, OfOneSampleFarOutsideLeavesTheRestBlack) {
    // One sample in the corner of a picture much wider than any search.
    Samples one;
    one.width = 100;
    one.height = 4;
    one.spp = 0;
    std::vector<std::uint64_t> first(401, 1);
    first[0] = 0;
    one.first = Array<std::uint64_t>(first);
    one.set_size(1);
    one.add("xy", 2, {0.5f, 0.5f});
    one.add("z", 1, {3});
    one.add("rgb", 3, {1, 1, 1});
    const TestFolder folder;
    const GraphRun run(tlfr_text(saved(folder, one), R"("per-pixel": 2, "seed": 3)"));
    ASSERT_EQ(run.picture.width(), 100);
    EXPECT_NEAR(run.picture.at(1, 0)[0], 1, 1e-5f);
}

TEST(Reconstruction, SeesAtInfinityWhatIsThere) {
    Samples s = random_samples(16, 16, 4, Kind_of::defocused);
    std::vector<float> z(s.size(), INFINITY), rgb;
    for (size_t i = 0; i < s.size(); ++i) rgb.insert(rgb.end(), {0.1f, 0.2f, 0.7f});
    s.add("z", 1, z);
    s.add("rgb", 3, rgb);
    const TestFolder folder;
    const GraphRun run(tlfr_text(saved(folder, s), R"("per-pixel": 16)"));
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) EXPECT_NEAR(run.picture.at(x, y)[2], 0.7f, 1e-5f);
}

}  // namespace
}  // namespace weft
