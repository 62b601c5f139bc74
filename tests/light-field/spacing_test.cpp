// output-locations' spacing: a pixel's locations share a (u, v, t) where that shows things at places near enough.
#include <fmt/format.h>

#include <algorithm>

#include "samples/analytic_scene.h"
#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {

// One plane at one depth, whose circles of confusion are `diameter` px, moved by `path` px over the shutter.
Samples plane(int width, int height, float diameter, float path) {
    Samples s = random_samples(width, height, 2, Kind_of::moving);
    s.lens = Lens{0, 0.5f * diameter};
    std::vector<float> z(s.size(), 4.0f), motion(3 * s.size());
    for (size_t i = 0; i < s.size(); ++i) motion[3 * i] = 4 * path;
    s.add("z", 1, z);
    s.add("motion", 3, motion);
    return s;
}

double counted(const GraphRun& run, const std::string& what) {
    double most = 0;
    for (const SegmentReport& segment : run.result.segments)
        for (const StageReport& stage : segment.stages)
            if (const auto at = stage.items.find(what); at != stage.items.end()) most = std::max(most, double(at->second));
    return most;
}

// Slices of 64 locations a pixel, one plane: how many times each sample was projected.
double slices(float diameter, float path, const std::string& locations) {
    const TestFolder folder;
    const Samples s = plane(32, 32, diameter, path);
    return counted(GraphRun(tlfr_text(saved(folder, s), locations)), "projected") / double(s.size());
}

TEST(Spacing, LeavesAsManySlicesAsTheBlurAsksFor) {
    const std::string apart = R"("per-pixel": 64)", near = apart + R"(, "spacing": 1)";
    EXPECT_NEAR(slices(0, 0, apart), 64, 1);
    EXPECT_NEAR(slices(0, 0, near), 1, 0.1);    // in focus and still
    EXPECT_NEAR(slices(2.9f, 0, near), 16, 1);  // 3.9 x 3.9 at least
    EXPECT_NEAR(slices(0, 7, near), 8, 1);      // along a line
    EXPECT_NEAR(slices(6.5f, 0, near), 64, 2);  // no fewer than there were
    EXPECT_NEAR(slices(2.9f, 0, apart + R"(, "spacing": 2)"), 8, 1);
}

TEST(Spacing, OfWhatIsFixedCountsNothing) {
    const std::string near = R"("per-pixel": 64, "spacing": 1)";
    EXPECT_NEAR(slices(2.9f, 7, near + R"(, "lens": "fixed")"), 8, 1);
    EXPECT_NEAR(slices(2.9f, 7, near + R"(, "time": "fixed")"), 16, 1);
}

// A still picture into which shadows of moving things fall: one light sample in a plane, faster than all others,
// that stopped the ray to a sample of the first pixel.
double slices_under(float path, int width) {
    const TestFolder folder, lights;
    const Samples still = plane(width, 32, 0, 0);
    Samples light = plane(width, 32, 0, 0);
    std::vector<float> motion(light.motion().begin(), light.motion().end());
    motion[3 * 70 + 1] = 4 * path;
    light.add("motion", 3, motion);
    std::vector<std::uint32_t> source(light.size());
    for (size_t i = 0; i < source.size(); ++i) source[i] = std::uint32_t(i);
    source[70] = 0;
    light.add_ids("source", source);
    std::string text = tlfr_text(saved(folder, still), R"("per-pixel": 64, "spacing": 1)");
    const std::string in = R"("in": {"hierarchy": "hierarchy"}, "set")";
    text.replace(text.find(in), in.size(), R"("in": {"hierarchy": "hierarchy", "shadow-paths": "paths"}, "set")");
    const std::string nodes = R"("nodes": {)";
    text.replace(text.find(nodes), nodes.size(),
                 nodes + R"("light": {"type": "read-samples", "set": {"file": ")" + saved(lights, light) + R"(", "channels": ["source"]}},
                     "paths": {"type": "shadow-paths", "in": {"shadows": "light", "samples": "samples"}},)");
    return counted(GraphRun(text), "projected") / double(still.size());
}

TEST(Spacing, CountsWhatShadowsMove) {
    EXPECT_NEAR(slices_under(0, 32), 1, 0.1);
    EXPECT_NEAR(slices_under(7, 32), 8, 0.1);
    EXPECT_NEAR(slices_under(40, 32), 64, 1);
}

TEST(Spacing, CountsShadowsWhereTheyFall) {
    // Two blocks; some samples are near both.
    const double once = slices_under(0, 64);
    EXPECT_NEAR(once, 1, 0.15);
    EXPECT_NEAR(slices_under(7, 64) / once, 0.5 * (8 + 1), 0.1);
    EXPECT_NEAR(slices_under(40, 64) / once, 0.5 * (64 + 1), 1);
}

TEST(Spacing, ReconstructsAsManyLocations) {
    const TestFolder folder;
    const std::string file = saved(folder, plane(40, 37, 3, 0));
    for (const char* locations : {R"("per-pixel": 21)", R"("per-pixel": 21, "spacing": 1)", R"("per-pixel": 21, "spacing": 1, "sets": 3)"})
        EXPECT_EQ(counted(GraphRun(tlfr_text(file, locations)), "locations"), 21 * 40 * 37) << locations;
}

// Nothing is blurred: whatever (u, v, t) and whatever batch a pixel's locations come in, they are the same.
TEST(PerLightPoint, ReconstructsTheSameLocations) {
    const TestFolder folder;
    const std::string file = saved(folder, plane(40, 37, 0, 0));
    for (const int n : {64, 100, 37}) {
        const auto run = [&](const std::string& more) { return GraphRun(tlfr_text(file, fmt::format(R"("per-pixel": {}, "spacing": 1{})", n, more))); };
        const GraphRun alone = run(""), together = run(R"(, "per-light-point": 4)");
        EXPECT_EQ(counted(together, "locations"), n * 40 * 37);
        const auto expected = values_of(alone.picture), got = values_of(together.picture);
        ASSERT_EQ(got.size(), expected.size());
        for (size_t i = 0; i < got.size(); ++i) ASSERT_NEAR(got[i], expected[i], 2e-5f * std::max(1.0f, std::abs(expected[i]))) << n << " " << i;
    }
}

// In focus on the left, blurred on the right, so that blocks share in different ways.
Samples two_depths() {
    Samples s = random_samples(70, 45, 3, Kind_of::moving_in_depth);
    std::vector<float> z(s.size());
    for (size_t i = 0; i < s.size(); ++i) z[i] = s.xy()[2 * i] < 35 ? 5.0f : 2.5f;
    s.add("z", 1, z);
    return s;
}

TEST(Spacing, GivesTheSameBitsForAnyTilesAndThreads) {
    const TestFolder folder;
    const std::string file = saved(folder, two_depths());
    for (const char* locations : {R"("per-pixel": 24, "spacing": 2)", R"("per-pixel": 20, "spacing": 3, "per-slice": 2, "sets": 2)",
                                  R"("per-pixel": 50, "spacing": 3, "per-slice": 2, "per-light-point": 2)"}) {
        const auto whole = values_of(GraphRun(tlfr_text(file, locations), 128, 1).picture);
        for (const int tile : {64, 32, 13, 1}) EXPECT_EQ(values_of(GraphRun(tlfr_text(file, locations), tile, 2).picture), whole) << tile;
    }
}

TEST(Spacing, ChangesThePictureLessThanAnotherSeedDoes) {
    const TestFolder folder;
    PlainContext ctx;
    AnalyticOptions options;
    options.width = 96;
    options.height = 64;
    options.spp = 4;
    const std::string file = saved(folder, analytic_samples("layers", options, ctx));
    const auto picture = [&](const std::string& more) { return values_of(GraphRun(tlfr_text(file, R"("per-pixel": 256)" + more)).picture); };
    const auto apart = picture(""), shared = picture(R"(, "spacing": 1)"), other = picture(R"(, "seed": 2)");
    double by_sharing = 0, by_seed = 0;
    for (size_t i = 0; i < apart.size(); ++i) {
        by_sharing += std::pow(double(shared[i]) - double(apart[i]), 2);
        by_seed += std::pow(double(other[i]) - double(apart[i]), 2);
    }
    EXPECT_GT(by_sharing, 0);
    EXPECT_LT(by_sharing, 1.5 * by_seed);
}

}  // namespace
}  // namespace weft
