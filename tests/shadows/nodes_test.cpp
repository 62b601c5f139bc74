// The nodes of shadow reconstruction on rendered scenes: against many samples a pixel, and on bad
// input.
#include <fmt/format.h>

#include <fstream>
#include <set>

#include "light-field/hierarchy.h"
#include "render/scene.h"
#include "shadows/light_view.h"
#include "tests/graph_run.h"
#include "tests/instruction_sets.h"

namespace weft {
namespace {

// A ball and a slab over the ground; `light` and `camera` are JSON members, `speed` the ball's.
std::string scene_text(const std::string& light, double speed = 0, const std::string& lens = "") {
    return fmt::format(R"({{"weft_scene": 1, "shutter": {{"open": 0, "close": 1}},
        "materials": {{"grey": {{"kind": "diffuse", "color": [0.6, 0.6, 0.6]}}}},
        "shapes": [{{"shape": "plane", "material": "grey", "scale": 10}},
                   {{"shape": "sphere", "material": "grey", "at": [0.9, 0.5, 0.4], "scale": 0.5, "velocity": [{}, 0, 0]}},
                   {{"shape": "cube", "material": "grey", "at": [-0.8, 0.9, 0], "scale": [0.5, 0.04, 0.4]}}],
        "lights": [{}],
        "camera": {{"at": [0, 3, 6], "target": [0, 0.3, 0], "fov": 28{}}}}})",
                       speed, light, lens);
}
const char* const quad =
    R"({"shape": "quad", "name": "key", "at": [0.5, 4, 0.5], "target": [0, 0, 0], "size": [1.2, 1.2], "radiance": [20, 20, 20]})";
const char* const disc =
    R"({"shape": "disc", "name": "key", "at": [0.5, 4, 0.5], "target": [0, 0, 0], "radius": 0.6, "radiance": [20, 20, 20]})";
const char* const ball =
    R"({"shape": "sphere", "name": "key", "at": [0.5, 4, 0.5], "radius": 0.6, "radiance": [8, 8, 8], "visible": false})";
const char* const moving_quad =
    R"({"shape": "quad", "name": "key", "at": [0.5, 4, 0.5], "target": [0.5, 0, 0.5], "size": [1, 1], "radiance": [20, 20, 20], "velocity": [0.8, 0, 0]})";

// The picture of a scene: reconstructed from 4 samples a pixel, the mean of 4, or of very many.
std::string graph_of(const std::string& file, const std::string& kind, int seed = 1) {
    const std::string head = fmt::format(R"({{"weft": 1, "nodes": {{
        "scene":  {{"type": "read-scene", "set": {{"file": "{}"}}}},
        "render": {{"type": "render-samples", "in": {{"scene": "scene"}}, "set": {{"width": 96, "height": 60, "spp": {}, "seed": {}, "max-depth": 1, "mode": "direct",
                   "channels": ["basic", "position", "geometric_normal", "normal", "albedo", "direct", "direct_unshadowed", "light_index", "light_point", "shadow_hit", "shadow_normal", "shadow_motion"]}}}},
        "write":  {{"type": "write-image", "in": {{"image": "picture"}}, "set": {{"file": "OUT", "depth": "float"}}}},)",
                                         file, kind == "reference" ? 256 : 4, seed);
    if (kind != "shadows" && kind != "recorded" && kind != "published")
        return head +
               R"("picture": {"type": "pixel-filter", "in": {"samples": "render"}, "set": {"filter": "box"}}}})";
    std::string text = head + R"(
        "view":      {"type": "fit-light-view", "in": {"samples": "render"}},
        "rays":      RAYS,
        "density":   {"type": "light-jacobian", "in": {"samples": "render", "light-view": "view"}},
        "separate":  {"type": "separate-light", "in": {"samples": "density", "light-view": "view"}},
        "direct":    {"type": "smooth-radiance", "in": {"samples": "separate.direct"}},
        "hierarchy": {"type": "build-hierarchy", "in": {"samples": "separate.rest"}},
        "locations": {"type": "output-locations", "in": {"hierarchy": "hierarchy"}, "set": {"per-pixel": 64}},
        "see":       {"type": "parts/seen-samples.json", "in": {"locations": "locations", "hierarchy": "hierarchy"}},
        "shadow":    {"type": "SHADOW",
                      "in": {"locations": "locations", "seen": "see.seen", "hierarchy": "hierarchy", "samples": "density", "light-view": "view", "light-samples": "rays"}},
        "shade":     {"type": "shade-visible", "in": {"colors": "see.colors", "shares": "shadow.shares", "queries": "shadow.queries", "direct": "direct"}},
        "picture":   {"type": "accumulate", "in": {"colors": "shade", "locations": "locations"}}}})";
    // As published: surfaces by triangles, depth taken for linear, an absolute bias.
    text.replace(
        text.find("SHADOW"), 6,
        kind == "published"
            ? R"(parts/soft-shadow-triangles.json", "set": {"test": "linear", "bias": 0.01}, "about": ")"
            : "parts/soft-shadow-z-reconstruct.json");
    return text.replace(
        text.find("RAYS"), 4,
        kind == "recorded"
            ? R"({"type": "light-samples-from-file", "in": {"samples": "render", "light-view": "view"}})"
            : R"({"type": "render-light-samples", "in": {"scene": "scene", "samples": "render", "light-view": "view"}})");
}

double rmse(const Image& a, const Image& b) {
    double sum = 0;
    for (size_t i = 0; i < a.pixels().size(); ++i)
        sum += std::pow(double(a.pixels()[i] - b.pixels()[i]), 2);
    return std::sqrt(sum / double(a.pixels().size()));
}

struct Case {
    const char* name;
    std::string scene;
};
class ShadowScene : public testing::TestWithParam<Case> {};

TEST_P(ShadowScene, IsNearerToTheTruthThanTheSamples) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << GetParam().scene;
    const Image truth = GraphRun(graph_of(file, "reference", 7)).picture;
    const double input = rmse(GraphRun(graph_of(file, "input")).picture, truth);
    const GraphRun one(graph_of(file, "shadows"));
    EXPECT_LT(rmse(one.picture, truth), 0.9 * input) << "input: " << input;
    // The same bits for any threads and tiles.
    EXPECT_EQ(values_of(GraphRun(graph_of(file, "shadows"), 17, 3).picture),
              values_of(one.picture));
}

// The fused kernels against the stages that they stand for, with every instruction set.
TEST_P(ShadowScene, IsTheSameStageByStage) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << GetParam().scene;
    for (const Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        const std::vector<float> fused = values_of(GraphRun(graph_of(file, "shadows")).picture),
                                 apart = values_of(
                                     GraphRun(graph_of(file, "shadows"), 32, 1, false).picture);
        ASSERT_EQ(fused.size(), apart.size());
        // What stands before what is told by rounded numbers: a vote in a hundred
        // thousand may differ, and with it a pixel.
        size_t unlike = 0;
        for (size_t i = 0; i < fused.size(); ++i)
            unlike += std::abs(fused[i] - apart[i]) > 1e-4f * std::max(1.0f, apart[i]);
        EXPECT_LE(unlike, fused.size() / 1000) << name_of(isa);
    }
}

// Samples that lit-receivers finds need not ask: the picture is that of asking for all.
TEST_P(ShadowScene, IsTheSameWhereAllAreAsked) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << GetParam().scene;
    for (const Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        const auto picture = [&](const char* set) {
            return values_of(GraphRun(graph_of(file, "shadows"), 32, 1, true, {set}).picture);
        };
        EXPECT_EQ(picture("shadow/lit.test=both-planes"), picture("shadow/lit.test=linear"))
            << name_of(isa);
    }
}

// A pixel's locations that see one surface, one of which asks the light for all.
TEST_P(ShadowScene, IsAsGoodWhereOneAsksForAll) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << GetParam().scene;
    const auto picture = [&](int tile, int threads, bool fused, const char* together) {
        return GraphRun(graph_of(file, "shadows"), tile, threads, fused,
                        {"locations.spacing=1", fmt::format("locations.per-light-point={}", together)})
            .picture;
    };
    const Image truth = GraphRun(graph_of(file, "reference", 7)).picture,
                alone = picture(32, 1, true, "1"), one = picture(32, 1, true, "4");
    // What is blurred keeps its points.
    const bool blurred = GetParam().scene.find("\"lens\"") != std::string::npos;
    EXPECT_EQ(values_of(one) == values_of(alone), blurred);
    // A quarter of the 64 points of the light.
    EXPECT_LT(rmse(one, truth), 1.25 * rmse(alone, truth));
    EXPECT_EQ(values_of(picture(17, 3, true, "4")), values_of(one));
    const std::vector<float> fused = values_of(one), apart = values_of(picture(32, 1, false, "4"));
    size_t unlike = 0;
    for (size_t i = 0; i < fused.size(); ++i)
        unlike += std::abs(fused[i] - apart[i]) > 1e-4f * std::max(1.0f, apart[i]);
    EXPECT_LE(unlike, fused.size() / 1000);
}

INSTANTIATE_TEST_SUITE_P(
    Lights, ShadowScene,
    testing::Values(Case{"quad", scene_text(quad)}, Case{"disc", scene_text(disc)},
                    Case{"ball", scene_text(ball)}, Case{"moving_light", scene_text(moving_quad)},
                    Case{"moving_ball_open_lens",
                         scene_text(quad, 1, R"(, "focus": 6.5, "lens": {"radius": 0.08})")}),
    [](const auto& of) { return std::string(of.param.name); });

TEST(ShadowPictures, AsPublishedToo) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << scene_text(quad);
    const Image truth = GraphRun(graph_of(file, "reference", 7)).picture;
    const double input = rmse(GraphRun(graph_of(file, "input")).picture, truth),
                 ours = rmse(GraphRun(graph_of(file, "shadows")).picture, truth),
                 published = rmse(GraphRun(graph_of(file, "published")).picture, truth);
    EXPECT_LT(published, input);
    EXPECT_LT(ours, 1.15 * published);
}

// Lights without size, and buffers in which nothing is blurred, take the same way.
TEST(ShadowPictures, HardShadowsStayHard) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    for (
        const char* light :
        {R"({"shape": "point", "name": "key", "at": [0.5, 4, 0.5], "intensity": [30, 30, 30]})",
         R"({"shape": "quad", "name": "key", "at": [0.5, 4, 0.5], "target": [0, 0, 0], "size": [1e-4, 1e-4], "radiance": [3e9, 3e9, 3e9]})"}) {
        std::ofstream(file) << scene_text(light);
        const Image truth = GraphRun(graph_of(file, "reference", 7)).picture;
        const double input = rmse(GraphRun(graph_of(file, "input")).picture, truth);
        for (const char* kind : {"shadows", "recorded"})
            EXPECT_LT(rmse(GraphRun(graph_of(file, kind)).picture, truth), 1.2 * input)
                << light << kind;
    }
}

TEST(LightSamplesFromFile, NeedNoScene) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    for (const std::string& scene :
         {scene_text(quad), scene_text(disc), scene_text(ball), scene_text(moving_quad),
          scene_text(quad, 1)}) {
        std::ofstream(file) << scene;
        const Image truth = GraphRun(graph_of(file, "reference", 7)).picture;
        const double input = rmse(GraphRun(graph_of(file, "input")).picture, truth);
        EXPECT_LT(rmse(GraphRun(graph_of(file, "recorded")).picture, truth), 0.9 * input);
    }
}

// Samples of a scene with all that light samples are made of, and a view of its light.
struct Seen {
    Samples samples;
    LightView view;
    explicit Seen(const std::string& scene) {
        TestFolder folder;
        const std::string file = folder / "scene.json";
        std::ofstream(file) << scene;
        const Scene read = RunNode("read-scene").set("file", file).out<Scene>("scene");
        samples = RunNode("render-samples")
                      .set("width", 48)
                      .set("height", 30)
                      .set("spp", 2)
                      .set("channels", Json::list({Json("all")}))
                      .in("scene", read)
                      .out<Samples>("samples");
        view = RunNode("fit-light-view").in("samples", samples).out<LightView>("light-view");
    }
};

// A ball's own lit side moves as the ball does, whether its shadow ray is stopped or not.
TEST(ShadowHits, MoveAsWhatTheyLieOn) {
    const Seen moving(scene_text(quad, 0.7));
    const auto motion = moving.samples.values("shadow_motion"),
               position = moving.samples.values("position"),
               hit = moving.samples.values("shadow_hit"), t = moving.samples.t();
    size_t own = 0, others = 0;
    for (size_t i = 0; i < moving.samples.size(); ++i) {
        if (!std::isfinite(moving.samples.z()[i])) continue;
        const auto to_ball = [&](std::span<const float> p) {
            return std::hypot(double(p[3 * i]) - (0.9 + 0.7 * double(t[i])),
                              double(p[3 * i + 1]) - 0.5, double(p[3 * i + 2]) - 0.4);
        };
        const bool on_ball = to_ball(hit) < 0.501;
        EXPECT_NEAR(motion[3 * i], on_ball ? 0.7f : 0.0f, 1e-4f) << i;
        (on_ball && to_ball(position) < 0.501 ? own : others) += 1;
    }
    EXPECT_GT(own, 20u);
    EXPECT_GT(others, 20u);
}

// Nothing moves, and the lens is a point: the seven dimensions are five or four.
TEST(LightSamplesFromFile, TakeStillAndPinholeBuffers) {
    const Seen still(scene_text(quad));
    EXPECT_FALSE(still.samples.has_lens());
    const Samples made = RunNode("light-samples-from-file")
                             .in("samples", still.samples)
                             .in("light-view", still.view)
                             .out<Samples>("light-samples");
    EXPECT_GT(made.size(), 0u);
    EXPECT_TRUE(made.motion().empty());
    Samples bare = still.samples;
    std::erase_if(bare.channels, [](const Channel& c) { return c.name == "shadow_hit"; });
    EXPECT_NE(error_of([&] {
                  RunNode("light-samples-from-file")
                      .in("samples", bare)
                      .in("light-view", still.view)
                      .out<Samples>("light-samples");
              }).find("needs shadow_hit"),
              std::string::npos);
}

TEST(LightSamplesFromFile, SaysWhatIsWrong) {
    const Seen round(scene_text(ball));
    const auto error = [](const Samples& samples, const LightView& view) {
        return error_of([&] {
            RunNode("light-samples-from-file")
                .in("samples", samples)
                .in("light-view", view)
                .out<Samples>("light-samples");
        });
    };
    const auto without = [](Samples samples, const char* channel) {
        std::erase_if(samples.channels, [&](const Channel& c) { return c.name == channel; });
        return samples;
    };
    EXPECT_EQ(error(round.samples, round.view), "");
    const std::string points = error(without(round.samples, "light_point"), round.view);
    EXPECT_NE(points.find("is a ball"), std::string::npos) << points;
    EXPECT_NE(points.find("expected light_point"), std::string::npos) << points;
    const Seen flat(scene_text(quad));
    EXPECT_EQ(error(flat.samples, flat.view), "");
    EXPECT_EQ(error(without(flat.samples, "light_point"), flat.view), "");
    EXPECT_NE(error(without(without(flat.samples, "light_point"), "light_uv"), flat.view)
                  .find("needs light_uv"),
              std::string::npos);
    Samples wrong = flat.samples;
    wrong.add("shadow_hit", 3, std::vector<float>(3 * wrong.size(), 77.0f));
    EXPECT_NE(error(wrong, flat.view).find("none of"), std::string::npos);
}

TEST(PassingRays, LieOnTheirRaysBeforeTheirHits) {
    const Seen flat(scene_text(quad, 1));
    const Samples hits = RunNode("light-samples-from-file")
                             .in("samples", flat.samples)
                             .in("light-view", flat.view)
                             .out<Samples>("light-samples");
    const auto hierarchy_of = [](const Samples& samples) {
        return RunNode("build-hierarchy").in("samples", samples).out<Hierarchy>("hierarchy");
    };
    const Hierarchy hierarchy = hierarchy_of(hits);
    const auto passes_of = [&](const Hierarchy& h, const Samples& camera) {
        return RunNode("passing-rays")
            .in("hits", h)
            .in("light-view", flat.view)
            .in("samples", camera)
            .out<Samples>("passes");
    };
    const Samples passes = passes_of(hierarchy, flat.samples);
    ASSERT_GT(passes.size(), 10u);
    const auto end = passes.values("end"), ends = hits.z();
    const std::set<float> known(ends.begin(), ends.end());
    for (size_t i = 0; i < passes.size(); ++i) {
        EXPECT_LT(passes.z()[i], end[i]) << i;
        EXPECT_GT(passes.z()[i], 0) << i;
        const auto near = known.lower_bound(end[i] * (1 - 1e-6f));
        ASSERT_TRUE(near != known.end()) << i;
        EXPECT_NEAR(*near, end[i], 1e-5f * end[i]) << i;
    }
    // They are light samples themselves.
    const Hierarchy by = hierarchy_of(passes);
    EXPECT_EQ(by.end.size(), passes.size());
    EXPECT_EQ(by.radius, hierarchy.radius);

    Samples few = flat.samples;
    few.add("light_density", 1, std::vector<float>(1, 1.0f));
    EXPECT_NE(error_of([&] { passes_of(hierarchy, few); }).find("'samples' are not those"),
              std::string::npos);
    EXPECT_NE(error_of([&] { passes_of(by, few); }).find("do not say which camera samples"),
              std::string::npos);
}

// Of a plane's samples most see all of the light, of those that something stops none do.
TEST(LitReceivers, AreThoseThatNothingComesNear) {
    for (const Seen& of : {Seen(scene_text(quad)), Seen(scene_text(disc, 0.5))}) {
        const Samples hits = RunNode("light-samples-from-file")
                                 .in("samples", of.samples)
                                 .in("light-view", of.view)
                                 .out<Samples>("light-samples");
        const auto hierarchy_of = [](const Samples& samples) {
            return RunNode("build-hierarchy").in("samples", samples).out<Hierarchy>("hierarchy");
        };
        const auto by = [&](const char* test) {
            return RunNode("lit-receivers")
                .set("test", test)
                .in("hits", hierarchy_of(hits))
                .in("hierarchy", hierarchy_of(of.samples))
                .in("samples", of.samples)
                .in("light-view", of.view)
                .out<Samples>("samples");
        };
        const Samples found = by("both-planes"), none = by("linear");
        const auto lit = found.values("all_lit"), hit = of.samples.values("shadow_hit"),
                   at = of.samples.values("position");
        size_t all = 0, surely = 0;
        for (size_t i = 0; i < found.size(); ++i) {
            if (!std::isfinite(of.samples.z()[i])) continue;
            ++all, surely += lit[i] > 0;
            double gap = 0;
            for (size_t c = 0; c < 3; ++c)
                gap = std::max(gap, std::abs(double(hit[3 * i + c] - at[3 * i + c])));
            if (gap > 0.01) {
                EXPECT_EQ(lit[i], 0) << i;
            }
        }
        EXPECT_GT(surely, all / 2);
        for (const float l : none.values("all_lit")) EXPECT_EQ(l, 0);
    }
}

TEST(LightSamplesFromCamera, AreTheCamerasHits) {
    const Seen flat(scene_text(quad));
    const Samples made = RunNode("light-samples-from-camera")
                             .in("samples", flat.samples)
                             .in("light-view", flat.view)
                             .out<Samples>("light-samples");
    size_t hits = 0;
    for (const float z : flat.samples.z()) hits += std::isfinite(z);
    EXPECT_EQ(made.size(), hits);
    const auto position = flat.samples.values("position");
    const auto& source = made.find("source")->ids;
    for (size_t i = 0; i < made.size(); ++i) {
        const size_t j = source[i];
        const Point3 p = flat.view.from_world(
            {double(position[3 * j]), double(position[3 * j + 1]), double(position[3 * j + 2])},
            0.5);
        EXPECT_NEAR(made.z()[i], p.z, 1e-4 * p.z) << i;
        const auto q = flat.view.project(p, double(made.uv()[2 * i]), double(made.uv()[2 * i + 1]));
        EXPECT_NEAR(made.xy()[2 * i], q[0], 0.05) << i;
        EXPECT_NEAR(made.xy()[2 * i + 1], q[1], 0.05) << i;
    }
}

// What a node says of a scene's samples.
std::string error_with(const std::string& scene, const std::string& light = "") {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << scene;
    return error_of([&] {
        const Scene read = RunNode("read-scene").set("file", file).out<Scene>("scene");
        const Samples samples = RunNode("render-samples")
                                    .set("width", 16)
                                    .set("height", 10)
                                    .set("spp", 1)
                                    .in("scene", read)
                                    .out<Samples>("samples");
        RunNode("fit-light-view")
            .set("light", light)
            .in("samples", samples)
            .out<LightView>("light-view");
    });
}

TEST(FitLightView, SaysWhatIsMissing) {
    EXPECT_NE(error_with(scene_text(quad), "kay").find("no light 'kay'; there are 'key'"),
              std::string::npos);
    EXPECT_NE(
        error_with(
            scene_text(
                R"({"shape": "quad", "name": "up", "at": [0, 4, 0], "target": [0, 9, 0], "size": [1, 1], "radiance": [1, 1, 1]})"))
            .find("lies in front of light 'up'"),
        std::string::npos);
    EXPECT_NE(
        error_with(
            scene_text(
                R"({"shape": "directional", "name": "sun", "at": [0, 4, 0], "target": [0, 0, 0], "irradiance": [1, 1, 1]})"))
            .find("directional only"),
        std::string::npos);
    EXPECT_EQ(error_with(scene_text(quad)), "");
    Samples bare;
    bare.width = bare.height = bare.spp = 1;
    bare.set_size(1);
    bare.add("xy", 2, {0.5f, 0.5f});
    bare.add("z", 1, {1});
    EXPECT_NE(error_of([&] {
                  RunNode("fit-light-view").in("samples", bare).out<LightView>("light-view");
              }).find("shadows need a light"),
              std::string::npos);
    bare.meta = parse_json_or_throw(
        R"({"lights": [{"name": "a", "shape": "quad", "origin": [0, 0], "ex": [1, 0, 0], "ey": [0, 1, 0], "half_extents": [1, 1]}]})",
        "meta");
    EXPECT_NE(error_of([&] {
                  RunNode("fit-light-view").in("samples", bare).out<LightView>("light-view");
              }).find("'camera'"),
              std::string::npos);
}

TEST(FitLightView, HoldsAllReceivers) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << scene_text(quad);
    const Scene scene = RunNode("read-scene").set("file", file).out<Scene>("scene");
    const Samples samples = RunNode("render-samples")
                                .set("width", 48)
                                .set("height", 30)
                                .set("spp", 2)
                                .in("scene", scene)
                                .out<Samples>("samples");
    const LightView view =
        RunNode("fit-light-view").in("samples", samples).out<LightView>("light-view");
    const Samples seen = RunNode("render-light-samples")
                             .in("scene", scene)
                             .in("samples", samples)
                             .in("light-view", view)
                             .out<Samples>("light-samples");
    size_t hits = 0;
    for (const float z : samples.z()) hits += std::isfinite(z);
    EXPECT_EQ(seen.size(), hits);
    EXPECT_EQ(seen.domain, "light");
    for (size_t i = 0; i < seen.size(); ++i) {
        EXPECT_GE(seen.xy()[2 * i], 0) << i;
        EXPECT_LT(seen.xy()[2 * i], float(view.width)) << i;
        EXPECT_GT(seen.z()[i], 0) << i;
    }
    EXPECT_TRUE(seen.motion().empty()) << "nothing moves";
}

}  // namespace
}  // namespace weft
