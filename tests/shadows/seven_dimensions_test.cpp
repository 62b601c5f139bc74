// Soft shadow, motion and defocus at once where the picture is known: a plane in focus under an
// edge that moves, seen through an open lens, is for each pixel the mean of what the edge leaves of
// the light there.
#include "tests/graph_run.h"
#include "tests/shadows/shadow_test.h"
#include "tests/shadows/visibility_test.h"

namespace weft {
namespace {

// Picture of a scene: reconstructed by parts/tlfr-7d.json, or the mean of its samples.
Image picture_of(const KnownShadow& known, const char* lens, const std::string& picture) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::string scene = known.scene();
    const size_t camera = scene.find("\"fov\"");
    scene.insert(camera, lens);
    std::ofstream(file) << scene;
    return GraphRun(fmt::format(R"({{"weft": 1, "nodes": {{
        "scene":   {{"type": "read-scene", "set": {{"file": "{}"}}}},
        "render":  {{"type": "render-samples", "in": {{"scene": "scene"}},
                    "set": {{"width": {}, "height": {}, "spp": {}, "seed": {}, "max-depth": 1, "mode": "direct", "channels": ["all"]}}}},
        "picture": {},
        "write":   {{"type": "write-image", "in": {{"image": "picture"}}, "set": {{"file": "OUT", "depth": "float"}}}}}}}})",
                                file, known.width, known.height, known.spp, known.seed, picture))
        .picture;
}

double past_moving(double x, double from, double speed) {
    constexpr int steps = 256;
    double sum = 0;
    for (int i = 0; i < steps; ++i)
        sum += past_edge_quad(x, from + speed * (i + 0.5) / steps, 10, 6);
    return sum / steps;
}

TEST(SevenDimensions, AMovingEdgeOverAPlaneInFocus) {
    const char* const lens = R"("focus": 3, "lens": {"radius": 0.1}, )";
    std::mt19937 random(17);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 3; ++i) {
        const double speed = i == 0 ? 0.6 : 0.6 * unit(random),
                     from = -0.5 * speed + (i == 0 ? 0 : 0.2 * unit(random) - 0.1);
        // Far around what is looked at: each point of the occluder is met by rays to receivers on
        // all sides of it.
        KnownShadow known;
        known.half_width = 3, known.width = known.height = 80;
        known.seed = i + 1;
        known.occluder = half_plane(from, speed);
        const Image shadow = picture_of(
            known, lens,
            R"({"type": "parts/tlfr-7d.json", "in": {"samples": "render"}, "set": {"locations": 256}})");
        known.occluder.clear();
        known.spp = 64;
        const Image open =
            picture_of(known, lens, R"({"type": "pixel-filter", "in": {"samples": "render"}})");
        double square = 0, bias = 0;
        int pixels = 0;
        const double side = 2 * known.half_width / known.width;
        for (int y = 25; y < 55; ++y)
            for (int x = 20; x < 60; ++x) {
                double exact = 0;
                for (int k = 0; k < 16; ++k)
                    exact += past_moving(ground_x(known, x) + side * ((k + 0.5) / 16 - 0.5), from,
                                         speed) /
                             16;
                if (exact <= 0 || exact >= 1) continue;
                const double error = double(shadow.at(x, y)[1]) / double(open.at(x, y)[1]) - exact;
                square += error * error, bias += error, ++pixels;
            }
        ASSERT_GT(pixels, 100);
        EXPECT_LT(std::sqrt(square / pixels), 0.012) << from << " " << speed;
        EXPECT_LT(std::abs(bias / pixels), 0.005) << from << " " << speed;
    }
}

}  // namespace
}  // namespace weft
