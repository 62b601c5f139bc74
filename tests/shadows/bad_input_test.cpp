// Soft shadows of what is missing, misplaced or without size: the right answer, or what is wrong.
#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "render/scene.h"
#include "shadows/light_view.h"
#include "tests/graph_run.h"

namespace weft {
namespace {

// A floor under a light at height 4; `shapes` and `lights` are JSON.
std::string scene_text(const std::string& shapes, const std::string& lights) {
    return fmt::format(R"({{"weft_scene": 1,
        "materials": {{"grey": {{"kind": "diffuse", "color": [0.6, 0.6, 0.6]}}}},
        "shapes": [{{"shape": "plane", "material": "grey", "scale": 10}}{}],
        "lights": [{}],
        "camera": {{"at": [0, 3, 6], "target": [0, 0.3, 0], "fov": 28}}}})",
                       shapes, lights);
}
std::string quad(double size) {
    return fmt::format(
        R"({{"shape": "quad", "name": "key", "at": [0, 4, 0], "target": [0, 0, 0], "size": [{0}, {0}], "radiance": [20, 20, 20]}})",
        size);
}

Scene scene_of(const std::string& text) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << text;
    return RunNode("read-scene").set("file", file).out<Scene>("scene");
}
Samples rendered(const Scene& scene) {
    return RunNode("render-samples")
        .in("scene", scene)
        .set("width", 24)
        .set("height", 16)
        .set("spp", 4)
        .set("max-depth", 1)
        .set("channels", Json::list({Json("all")}))
        .out<Samples>("samples");
}
LightView view_of(const Samples& samples) {
    return RunNode("fit-light-view").in("samples", samples).out<LightView>("light-view");
}
Samples light_samples(const Scene& scene, const Samples& samples, const LightView& view) {
    return RunNode("render-light-samples")
        .in("scene", scene)
        .in("samples", samples)
        .in("light-view", view)
        .out<Samples>("light-samples");
}
Samples without(Samples samples, const std::string& channel) {
    std::erase_if(samples.channels, [&](const Channel& c) { return c.name == channel; });
    return samples;
}

// The whole row from samples that recorded their shadow rays, reconstructed; the mean of the same
// samples beside it.
std::string row(const std::string& file, const std::string& from, const char* picture) {
    return fmt::format(R"({{"weft": 1, "nodes": {{
        "scene":  {{"type": "read-scene", "set": {{"file": "{}"}}}},
        "render": {{"type": "render-samples", "in": {{"scene": "scene"}}, "set": {{"width": 48, "height": 30, "spp": 4, "max-depth": 1, "channels": ["all"]}}}},
        {}
        "write":  {{"type": "write-image", "in": {{"image": "picture"}}, "set": {{"file": "OUT", "depth": "float"}}}},
        "picture": {}}}}})",
                       file, from, picture);
}
const char* const box = R"({"type": "pixel-filter", "in": {"samples": "render"}})";
const char* const seven =
    R"({"type": "parts/tlfr-7d.json", "in": {"samples": "render"}, "set": {"locations": 32}})";

double mean(const Image& image) {
    double sum = 0;
    for (const float v : image.pixels()) sum += double(v);
    return sum / double(image.pixels().size());
}

// A scene without lights is lit evenly, and by a sun: nothing that has a place.
TEST(ShadowInput, NoLightIsSaid) {
    const Samples samples = rendered(scene_of(scene_text("", "")));
    const std::string error = error_of([&] { view_of(samples); });
    EXPECT_NE(error.find("expected one at a distance"), std::string::npos) << error;
    Samples dark = samples;
    dark.meta.set("lights", Json::list());
    const std::string none = error_of([&] { view_of(dark); });
    EXPECT_NE(none.find("shadows need a light"), std::string::npos) << none;
}

TEST(ShadowInput, SamplesWithoutPlacesAreRefused) {
    const Scene scene = scene_of(scene_text("", quad(1)));
    const Samples samples = rendered(scene);
    const LightView view = view_of(samples);
    const Samples flat = without(samples, "z");
    EXPECT_NE(error_of([&] { view_of(flat); }).find("'fit-light-view' needs z"), std::string::npos);
    for (const char* node : {"render-light-samples", "light-samples-from-camera",
                             "light-samples-from-file", "light-jacobian"}) {
        const std::string error = error_of([&] {
            RunNode run(node);
            run.in("samples", flat).in("light-view", view);
            if (node == std::string("render-light-samples")) run.in("scene", scene);
            run.run();
        });
        EXPECT_NE(error.find(fmt::format("'{}' needs z", node)), std::string::npos) << error;
    }
    EXPECT_NE(error_of([&] {
                  RunNode("light-jacobian")
                      .in("samples", without(without(samples, "normal"), "geometric_normal"))
                      .in("light-view", view)
                      .run();
              }).find("needs normal"),
              std::string::npos);
}

// A film that holds a part of the receivers: the others have no light sample, and that is said.
TEST(ShadowInput, ReceiversOutsideTheLightsViewHaveNoLightSample) {
    const Scene scene = scene_of(scene_text("", quad(1)));
    const Samples samples = rendered(scene);
    LightView view = view_of(samples);
    const size_t all = light_samples(scene, samples, view).size();
    view.width /= 2;
    RunNode run("render-light-samples");
    const Samples part = run.in("scene", scene)
                             .in("samples", samples)
                             .in("light-view", view)
                             .out<Samples>("light-samples");
    ASSERT_EQ(run.ctx.warnings.size(), 1u);
    const std::string lost =
        fmt::format("{} receivers lie outside the view of light 'key'", all - part.size());
    EXPECT_EQ(run.ctx.warnings[0].find(lost), 0u) << run.ctx.warnings[0];
    for (const char* node : {"light-samples-from-camera", "light-samples-from-file"}) {
        RunNode other(node);
        other.in("samples", samples).in("light-view", view).out<Samples>("light-samples");
        ASSERT_EQ(other.ctx.warnings.size(), 1u) << node;
        EXPECT_NE(other.ctx.warnings[0].find("outside the view"), std::string::npos) << node;
    }
    EXPECT_LT(part.size(), 0.9 * double(all));
    EXPECT_GT(part.size(), 0.1 * double(all));
    for (size_t i = 0; i < part.size(); ++i) EXPECT_LT(part.xy()[2 * i], float(view.width)) << i;
}

// A ball among its receivers: its view looks at most of them. What is behind it stays as it is lit
// without shadows, and is counted in the report.
TEST(ShadowInput, ReceiversBehindABallAreCounted) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << scene_text(
        R"(, {"shape": "plane", "material": "grey", "at": [0, 1.2, -2], "rotate": [50, 0, 0], "scale": 0.8})",
        R"({"shape": "sphere", "name": "key", "at": [0, 0.7, -0.5], "radius": 0.1, "radiance": [20, 20, 20], "visible": false})");
    std::stringstream text;
    text << std::ifstream(std::string(WEFT_SOURCE_DIR) + "/graphs/soft-shadows-light-field.json")
                .rdbuf();
    for (const bool fuse : {true, false}) {
        const GraphRun run(
            text.str(), 32, 1, fuse,
            {"scene=" + file, "width=48", "height=30", "locations=8", "out=OUT"});
        EXPECT_TRUE(std::any_of(run.warnings.begin(), run.warnings.end(), [](const auto& w) {
            return w.find("outside the view of light 'key'") != std::string::npos;
        }));
        std::uint64_t outside = 0, queries = 0;
        for (const SegmentReport& segment : run.result.segments)
            for (const StageReport& stage : segment.stages)
                for (const auto& [name, count] : stage.items) {
                    if (name == "outside-view") outside += count;
                    if (name == "queries") queries += count;
                }
        EXPECT_EQ(queries, 48u * 30 * 8);
        EXPECT_GT(outside, queries / 50);
        EXPECT_LT(outside, queries / 2);
        EXPECT_GT(mean(run.picture), 0);
    }
}

TEST(ShadowInput, LightsWithoutSizeCastHardShadows) {
    // A board that hides the light from half of the floor; nothing lies between dark and lit.
    for (
        const char* light :
        {R"({"shape": "quad", "name": "key", "at": [0, 4, 0], "target": [0, 0, 0], "size": [1e-7, 1e-7], "radiance": [1e15, 1e15, 1e15]})",
         R"({"shape": "point", "name": "key", "at": [0, 4, 0], "intensity": [20, 20, 20]})"}) {
        const Scene scene = scene_of(scene_text(
            R"(, {"shape": "plane", "material": "grey", "at": [-20, 2, 0], "scale": [20, 1, 20]})",
            light));
        const Samples samples = rendered(scene);
        const LightView view = view_of(samples);
        const Samples rays = light_samples(scene, samples, view);
        const auto position = samples.values("position");
        const auto& source = rays.find("source")->ids;
        ASSERT_GT(rays.size(), 1000u);
        for (size_t i = 0; i < rays.size(); ++i) {
            const size_t j = source[i];
            const Point3 at{double(position[3 * j]), double(position[3 * j + 1]),
                            double(position[3 * j + 2])};
            if (std::abs(at.x) < 1e-3) continue;
            const double own = view.from_world(at, 0.5).z;
            const bool hidden = at.x < 0 && at.y < 1;
            EXPECT_EQ(double(rays.z()[i]) < 0.9 * own, hidden) << at.x << " " << at.y;
        }
    }
}

// Lights that geometry encloses reach nothing; they are not let out.
TEST(ShadowInput, LightsInsideGeometryLeaveTheSceneDark) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << scene_text("", quad(1));
    const double lit = mean(GraphRun(row(file, "", box)).picture);
    for (const double half : {0.9, 0.55}) {
        std::ofstream(file) << scene_text(
            fmt::format(
                R"(, {{"shape": "cube", "material": "grey", "at": [0, 4, 0], "scale": {}}})", half),
            quad(1));
        EXPECT_EQ(mean(GraphRun(row(file, "", box)).picture), 0) << half;
        const GraphRun run(row(file, "", seven));
        EXPECT_LT(mean(run.picture), 2e-3 * lit) << half;
        EXPECT_TRUE(std::any_of(run.warnings.begin(), run.warnings.end(), [](const auto& text) {
            return text.find("inside geometry") != std::string::npos;
        })) << half;
    }
}

// Neither lens nor shutter is open, and nothing is hidden: what is left is the mean of the samples.
TEST(ShadowInput, PinholeAndStillBuffersTakeTheSevenDimensionalRow) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << scene_text(
        R"(, {"shape": "cube", "material": "grey", "at": [0, 1, 0], "scale": 0.3})", quad(1));
    const Image few = GraphRun(row(file, "", box)).picture;
    const Image all = GraphRun(row(file, "", seven)).picture;
    EXPECT_NEAR(mean(all), mean(few), 0.01 * mean(few));
    // One more buffer of the same, with a lens and a time for each sample that change nothing.
    std::ofstream(file) << scene_text("", quad(1));
    EXPECT_NEAR(mean(GraphRun(row(file, "", seven)).picture),
                mean(GraphRun(row(file, "", box)).picture), 1e-2);
}

}  // namespace
}  // namespace weft
