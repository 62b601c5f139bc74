// Reconstructions of flat discs before a backdrop, whose coverage is known: alpha is the part that
// is covered.
#include <array>

#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {

struct Disc {
    float x, y, radius;  // px, seen from the lens centre at half time
};

// Discs of one depth and velocity, before a backdrop at infinity; a sample stratified in each of
// `spp` parts of a pixel.
struct DiscScene {
    int width = 128, height = 96, spp = 4;
    float slope = 0;  // of the discs, px per unit of lens; the backdrop is as sharp as it can be
    std::array<float, 2> velocity = {0, 0};  // px per shutter
    float light = 1;                         // of the discs; the backdrop's is 0.05
    std::vector<Disc> discs;

    Samples samples(unsigned seed) const {
        std::mt19937 random(seed);
        std::uniform_real_distribution<float> unit(0, 1);
        Samples s;
        s.width = width;
        s.height = height;
        s.spp = spp;
        // Slope 0 at depth 8; C0 / z + C1 with C1 = 4.
        s.lens = Lens{-32, 4};
        const float depth = 32 / (4 - slope);
        std::vector<float> xy, uv, t, z, motion, rgb, alpha;
        const int side = int(std::ceil(std::sqrt(float(spp))));
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int i = 0; i < spp; ++i) {
                    // Strata in the pixel; lens and time are drawn by themselves.
                    const float sx = float(x) + (float(i % side) + unit(random)) / float(side);
                    const float rows = std::ceil(float(spp) / float(side));
                    const float sy = float(y) + (float(i / side) + unit(random)) / rows;
                    const float r = std::sqrt(unit(random)), a = 6.2831853f * unit(random);
                    const float u = r * std::cos(a), v = r * std::sin(a), time = unit(random);
                    const bool hit = covered(sx, sy, u, v, time);
                    const float radiance = hit ? light : 0.05f;
                    xy.insert(xy.end(), {sx, sy});
                    uv.insert(uv.end(), {u, v});
                    t.push_back(time);
                    z.push_back(hit ? depth : INFINITY);
                    motion.insert(motion.end(), {hit ? velocity[0] * depth : 0,
                                                 hit ? velocity[1] * depth : 0, 0});
                    rgb.insert(rgb.end(), {radiance, radiance, radiance});
                    alpha.push_back(hit ? 1.0f : 0.0f);
                }
        s.set_size(z.size());
        s.add("xy", 2, xy);
        s.add("uv", 2, uv);
        s.add("t", 1, t);
        s.add("z", 1, z);
        s.add("motion", 3, motion);
        s.add("rgb", 3, rgb);
        s.add("alpha", 1, alpha);
        return s;
    }
    bool covered(float x, float y, float u, float v, float t) const {
        for (const Disc& disc : discs) {
            const float dx = x - disc.x - slope * u - velocity[0] * (t - 0.5f);
            const float dy = y - disc.y - slope * v - velocity[1] * (t - 0.5f);
            if (dx * dx + dy * dy < disc.radius * disc.radius) return true;
        }
        return false;
    }
};

// Part of each pixel's rays that a disc stops.
std::vector<float> coverage_of(const DiscScene& scene) {
    constexpr int rays = 1024;
    std::vector<float> part;
    std::mt19937 random(99);
    std::uniform_real_distribution<float> unit(0, 1);
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            int hits = 0;
            for (int i = 0; i < rays; ++i) {
                const float r = std::sqrt((float(i % 32) + unit(random)) / 32),
                            a = 6.2831853f * (float(i / 32) + unit(random)) / 32;
                hits += scene.covered(float(x) + unit(random), float(y) + unit(random),
                                      r * std::cos(a), r * std::sin(a), unit(random));
            }
            part.push_back(float(hits) / rays);
        }
    return part;
}

// Whether all pixels as near as this are wholly inside, or all wholly outside.
bool all_alike(const DiscScene& scene, const std::vector<float>& exact, size_t i, int near) {
    const int px = int(i) % scene.width, py = int(i) / scene.width;
    for (int y = std::max(py - near, 0); y <= std::min(py + near, scene.height - 1); ++y)
        for (int x = std::max(px - near, 0); x <= std::min(px + near, scene.width - 1); ++x) {
            const float other = exact[size_t(y) * size_t(scene.width) + size_t(x)];
            if (other != exact[i] || (other != 0 && other != 1)) return false;
        }
    return true;
}

struct Look {
    const char* name;
    float slope, velocity;
};

class Alpha : public testing::TestWithParam<std::tuple<int, Look>> {};

TEST_P(Alpha, IsThePartThatIsCovered) {
    const auto& [spp, look] = GetParam();
    DiscScene scene;
    scene.width = 80;
    scene.height = 64;
    scene.spp = spp;
    scene.slope = look.slope;
    scene.velocity = {look.velocity, -0.5f * look.velocity};
    scene.discs = {{32, 30, 14}, {58, 38, 9}};
    const TestFolder folder;
    PlainContext ctx;
    write_npz(scene.samples(5), folder / "samples.npz", false, ctx);
    const GraphRun run(R"({"weft": 1, "nodes": {
        "samples":   {"type": "read-samples", "set": {"file": ")" +
                       (folder / "samples.npz") + R"("}},
        "hierarchy": {"type": "build-hierarchy", "in": {"samples": "samples"}},
        "locations": {"type": "output-locations", "in": {"hierarchy": "hierarchy"}, "set": {"per-pixel": 64}},
        "reproject": {"type": "reproject", "in": {"locations": "locations", "hierarchy": "hierarchy"}},
        "surfaces":  {"type": "same-surface-cluster", "in": {"candidates": "reproject.candidates"}},
        "coverage":  {"type": "coverage", "in": {"candidates": "reproject.candidates", "surfaces": "surfaces", "locations": "locations"}},
        "filter":    {"type": "filter-visible", "in": {"candidates": "reproject.candidates", "surfaces": "surfaces", "visibility": "coverage.visibility"}},
        "retry":     {"type": "parts/tlfr-retry.json",
                      "in": {"colors": "filter", "undecided": "coverage.undecided", "hierarchy": "hierarchy", "projection": "reproject.projection"}},
        "picture":   {"type": "accumulate", "in": {"colors": "retry.colors", "locations": "locations"}, "set": {"alpha": true}},
        "write":     {"type": "write-image", "in": {"image": "picture"}, "set": {"file": "OUT", "depth": "float"}}}})");
    ASSERT_EQ(run.picture.channels(), 4);
    const std::vector<float> exact = coverage_of(scene);
    double squares = 0, sum = 0, expected = 0;
    for (size_t i = 0; i < exact.size(); ++i) {
        const float alpha = run.picture.pixels()[4 * i + 3];
        ASSERT_GE(alpha, 0);
        ASSERT_LE(alpha, 1 + 1e-5f);
        squares += std::pow(double(alpha) - double(exact[i]), 2);
        sum += double(alpha);
        expected += double(exact[i]);
        if (all_alike(scene, exact, i, 7)) {
            EXPECT_NEAR(alpha, exact[i], 1e-5) << "pixel " << i;
        }
    }
    // Edges of one sample a pixel are known to two pixels. What a hull of samples leaves out of an
    // edge is lost.
    EXPECT_LT(std::sqrt(squares / double(exact.size())), spp == 1 ? 0.06 : 0.035) << look.name;
    EXPECT_NEAR(sum / expected, 1, spp == 1 ? 0.07 : 0.035) << look.name;
}

INSTANTIATE_TEST_SUITE_P(
    All, Alpha,
    testing::Combine(testing::Values(1, 3, 4, 8),
                     testing::Values(Look{"in focus, still", 0, 0}, Look{"before focus", -4, 0},
                                     Look{"moving", 0, 8}, Look{"moving before focus", -3, 5})));

// Radiance above the backdrop's, in pixels of it.
double light_of(const DiscScene& scene, const Samples& s) {
    double sum = 0;
    for (size_t i = 0; i < s.size(); ++i) sum += double(s.rgb()[3 * i]) - 0.05;
    return sum / scene.spp;
}
double light_of(const Image& picture) {
    double sum = 0;
    for (int y = 0; y < picture.height(); ++y)
        for (int x = 0; x < picture.width(); ++x) sum += double(picture.at(x, y)[0]) - 0.05;
    return sum;
}

class SmallHighlights : public testing::TestWithParam<std::tuple<int, Look>> {};

// Light of the picture over that of its samples.
double kept_light(const DiscScene& scene, const Samples& samples, const std::string& picture) {
    const TestFolder folder;
    PlainContext ctx;
    write_npz(samples, folder / "samples.npz", false, ctx);
    const GraphRun run(tlfr_text(folder / "samples.npz", R"("per-pixel": 64)", picture));
    return light_of(run.picture) / light_of(scene, samples);
}

DiscScene scene_of(int spp, const Look& look) {
    DiscScene scene;
    scene.spp = spp;
    scene.slope = look.slope;
    scene.velocity = {look.velocity, -0.5f * look.velocity};
    return scene;
}

TEST_P(SmallHighlights, KeepTheirLight) {
    const auto& [spp, look] = GetParam();
    DiscScene scene = scene_of(spp, look);
    // On a loose grid, away from the border, over which light would be carried out of the picture.
    std::mt19937 random(11);
    std::uniform_real_distribution<float> unit(0, 1);
    for (float y = 16; y < 80; y += 6)
        for (float x = 16; x < 112; x += 6)
            scene.discs.push_back(
                {x + 3 * unit(random), y + 3 * unit(random), 0.7f + 0.5f * unit(random)});
    const Samples samples = scene.samples(5);
    // Taken as solid or not at all, as hulls of their few samples have it, they would keep 53 to 87
    // %.
    const double kept = kept_light(scene, samples, "picture");
    EXPECT_GT(kept, spp == 8 ? 0.7 : 0.84) << look.name;
    EXPECT_LT(kept, 1.15) << look.name;
    EXPECT_NEAR(kept_light(scene, samples, "energy"), 1, 0.01) << look.name;
}

// A thousand times as bright as what is around it, with nothing near to make up for it.
TEST_P(SmallHighlights, KeepItOneByOne) {
    const auto& [spp, look] = GetParam();
    DiscScene scene = scene_of(spp, look);
    scene.light = 50;
    scene.discs = {{64.3f, 48.2f, 1}};
    for (const unsigned seed : {1u, 2u, 3u}) {
        const Samples samples = scene.samples(seed);
        if (!(light_of(scene, samples) > 0)) continue;
        EXPECT_NEAR(kept_light(scene, samples, "energy"), 1, 0.01)
            << look.name << ", seed " << seed;
    }
}

INSTANTIATE_TEST_SUITE_P(
    All, SmallHighlights,
    testing::Combine(testing::Values(1, 3, 4, 8),
                     testing::Values(Look{"in focus, still", 0, 0}, Look{"before focus", -3, 0},
                                     Look{"moving", 0, 6}, Look{"moving before focus", -3, 5})));

// Means of all samples are no measure for what one place on the lens sees.
TEST(SampleMeans, AreLeftOutWhereThePictureIsAnother) {
    DiscScene scene = scene_of(4, {"before focus", -6, 0});
    scene.discs = {{64, 48, 12}};
    const TestFolder folder;
    PlainContext ctx;
    write_npz(scene.samples(1), folder / "samples.npz", false, ctx);
    const std::string pinhole = R"("per-pixel": 16, "lens": "fixed")";
    const GraphRun plain(tlfr_text(folder / "samples.npz", pinhole)),
        held(tlfr_text(folder / "samples.npz", pinhole, "energy"));
    EXPECT_TRUE(std::ranges::equal(plain.picture.pixels(), held.picture.pixels()));
    ASSERT_EQ(held.warnings.size(), 1u);
    EXPECT_NE(held.warnings[0].find("means: locations are all at one place on the lens"), std::string::npos);
}

}  // namespace
}  // namespace weft
