// The path tracer as a function of points, and adaptive samples of scenes in other reconstructions.
#include <gtest/gtest.h>

#include <cmath>

#include "adaptive/leaf_tree.h"
#include "adaptive/sampler_function.h"
#include "adaptive/adaptive_tree.h"
#include "render/scene.h"
#include "tests/graph_run.h"

namespace weft {
namespace {

Scene scene_of(const std::string& file) {
    return RunNode("read-scene").set("file", Json(std::string(WEFT_SOURCE_DIR) + "/graphs/scenes/" + file)).out<Scene>("scene");
}
RunNode sampler_node(const Scene& scene, const std::string& mode = "direct") {
    RunNode node("scene-sampler");
    node.in("scene", scene).set("width", Json(32.0)).set("height", Json(18.0)).set("mode", Json(mode));
    return node;
}
Json names(std::initializer_list<const char*> list) {
    Json json = Json::list();
    for (const char* name : list) json.items.emplace_back(name);
    return json;
}
std::vector<std::string> axes_of(const SamplerFunction& sampler) {
    std::vector<std::string> all;
    for (const SamplerAxis& axis : sampler.axes) all.push_back(axis.name);
    return all;
}

TEST(SceneSampler, TakesTheAxesThatMatter) {
    using List = std::vector<std::string>;
    const Scene moving = scene_of("adaptive-motion.json"), lens = scene_of("adaptive-lens.json"), light = scene_of("adaptive-light.json");
    const SamplerFunction t = sampler_node(moving).out<SamplerFunction>("sampler");
    EXPECT_EQ(axes_of(t), (List{"x", "y", "t"}));
    EXPECT_GT(t.axes[2].scale, 0);
    const SamplerFunction uv = sampler_node(lens).out<SamplerFunction>("sampler");
    EXPECT_EQ(axes_of(uv), (List{"x", "y", "u", "v"}));
    EXPECT_GE(uv.axes[2].scale, 1);
    ASSERT_TRUE(uv.lens.has_value());
    EXPECT_EQ(axes_of(sampler_node(light, "ambient-occlusion").out<SamplerFunction>("sampler")), (List{"x", "y", "bounce-u", "bounce-v"}));
    EXPECT_EQ(axes_of(sampler_node(light).set("axes", names({"light-v", "auto", "light-u", "light-v"})).out<SamplerFunction>("sampler")),
              (List{"x", "y", "light-v", "light-u"}));
    EXPECT_NE(error_of([&] { sampler_node(light).set("axes", names({"lihgt-u"})).out<SamplerFunction>("sampler"); }).find("no axis 'lihgt-u'; there are auto, u"), std::string::npos);
}

// The same point gives the same bits, alone and among others; another hidden seed gives others only where something is hidden.
TEST(SceneSampler, IsAFunctionOfItsPoint) {
    const Scene scene = scene_of("adaptive-light.json");
    for (const bool hidden : {false, true}) {
        RunNode node = sampler_node(scene);
        if (!hidden) node.set("axes", names({"light-u", "light-v"}));
        const SamplerFunction sampler = node.out<SamplerFunction>("sampler");
        const size_t n = 1500, stride = sampler.values();
        std::vector<std::vector<float>> at(sampler.dimensions(), std::vector<float>(n));
        for (size_t d = 0; d < at.size(); ++d)
            for (size_t i = 0; i < n; ++i) at[d][i] = float((i * (2 * d + 3) * 379 + d) % 1009) / 1009;
        const auto evaluate = [&](size_t begin, size_t end, std::uint64_t seed) {
            std::vector<std::span<const float>> part;
            for (const auto& axis : at) part.push_back(std::span(axis).subspan(begin, end - begin));
            std::vector<float> values(stride * (end - begin));
            sampler.evaluate({part}, seed, values);
            return values;
        };
        const auto all = evaluate(0, n, 0), other = evaluate(0, n, 1);
        for (const size_t i : {0u, 7u, 1023u, 1024u, 1499u}) {
            const auto one = evaluate(i, i + 1, 0);
            for (size_t k = 0; k < stride; ++k) EXPECT_EQ(one[k], all[stride * i + k]);
        }
        size_t differ = 0;
        for (size_t i = 0; i < n; ++i) differ += all[stride * i] != other[stride * i];
        if (hidden)
            EXPECT_GT(differ, n / 4);
        else
            EXPECT_EQ(differ, 0u);
    }
}

// Explicit axes do not change what the picture is.
TEST(SceneSampler, ShowsWhatTheRendererDoes) {
    for (const char* file : {"adaptive-motion.json", "adaptive-lens.json", "adaptive-light.json"}) {
        const Scene scene = scene_of(file);
        const SamplerFunction sampler = sampler_node(scene).set("axes", names({"auto", "light-u", "light-v"})).out<SamplerFunction>("sampler");
        const Samples even = RunNode("uniform-samples").in("sampler", sampler).set("per-pixel", Json(64.0)).out<Samples>("samples");
        const Samples rendered = RunNode("render-samples").in("scene", scene).set("width", Json(32.0)).set("height", Json(18.0)).set("mode", Json("direct")).set("spp", Json(64.0)).out<Samples>("samples");
        const Image a = RunNode("pixel-filter").in("samples", even).out<Image>("image"), b = RunNode("pixel-filter").in("samples", rendered).out<Image>("image");
        double off = 0, mean = 0;
        for (size_t i = 0; i < a.pixels().size(); ++i) off += std::abs(double(a.pixels()[i]) - double(b.pixels()[i])), mean += double(b.pixels()[i]);
        EXPECT_LT(off / mean, 0.02) << file;
        double sum_a = 0;
        for (const float x : a.pixels()) sum_a += double(x);
        EXPECT_NEAR(sum_a / mean, 1, 0.003) << file;
        for (const char* channel : {"z", "alpha"}) EXPECT_FALSE(even.values(channel).empty()) << channel;
    }
}

struct AdaptiveOfScene {
    Samples samples;
    LeafTree leaves;
    std::vector<std::string> warnings;
};
AdaptiveOfScene adaptive_of(const SamplerFunction& sampler, const std::string& node = "adaptive-samples", double budget = 8) {
    AdaptiveOfScene made;
    RunNode run(node);
    run.in("sampler", sampler).set("budget", Json(budget));
    run.run({Slot{"samples", &type_info<Samples>(), &made.samples, {}}, Slot{"leaves", &type_info<LeafTree>(), &made.leaves, {}}});
    made.warnings = run.ctx.warnings;
    return made;
}

// Two to six axes: weights add up to the pixels, and hidden lights are noticed only where they are hidden.
TEST(AdaptiveSamples, OfScenesAddUp) {
    const Scene motion = scene_of("adaptive-motion.json"), lens = scene_of("adaptive-lens.json"), light = scene_of("adaptive-light.json");
    const SamplerFunction samplers[] = {
        sampler_node(motion).set("axes", names({"t"})).out<SamplerFunction>("sampler"),
        sampler_node(lens).out<SamplerFunction>("sampler"),
        sampler_node(lens).set("axes", names({"u", "v", "light-u", "light-v"})).out<SamplerFunction>("sampler"),
        sampler_node(light, "ambient-occlusion").out<SamplerFunction>("sampler"),
    };
    const size_t dimensions[] = {3, 4, 6, 4};
    for (size_t k = 0; k < 4; ++k)
        for (const char* node : {"adaptive-samples", "probability-samples"}) {
            const AdaptiveOfScene made = adaptive_of(samplers[k], node);
            EXPECT_EQ(made.leaves.dimensions(), dimensions[k]);
            EXPECT_EQ(made.samples.size(), 8u * 32 * 18);
            double weight = 0;
            for (const float w : made.samples.values("weight")) weight += double(w);
            EXPECT_NEAR(weight / (32 * 18), 1, 1e-4) << node;
            EXPECT_TRUE(made.warnings.empty()) << node << ", " << k << ": " << made.warnings[0];
        }
    const auto hidden = adaptive_of(sampler_node(light).set("axes", names({})).out<SamplerFunction>("sampler"));
    ASSERT_EQ(hidden.warnings.size(), 1u);
    EXPECT_NE(hidden.warnings[0].find("no axis explains"), std::string::npos);
}

// Buffers with a varying number of samples and weights go through other families' graphs.
TEST(AdaptiveSamples, AreReadByOtherReconstructions) {
    const Scene scene = scene_of("adaptive-lens.json");
    RunNode node = sampler_node(scene);
    node.set("channels", names({"basic", "position", "normal", "albedo", "bounce", "position2", "normal2", "albedo2", "direct", "specular", "diffuse"}));
    const AdaptiveOfScene made = adaptive_of(node.out<SamplerFunction>("sampler"));
    TestFolder folder;
    const std::string buffer = folder / "adaptive.npz";
    RunNode("write-samples").in("samples", made.samples).set("file", Json(buffer)).run();
    for (const char* graph : {"tlfr.json", "rpf.json"}) {
        if (std::string(graph) == "rpf.json" && !Registry::instance().type("build-vectors")) continue;
        Overrides overrides;
        overrides.set.push_back("samples=" + buffer);
        overrides.set.push_back("out=" + (folder / "out.exr"));
        LoadOptions options;
        options.for_run = true;
        options.overrides = overrides;
        const Loaded loaded = load_graph(std::string(WEFT_SOURCE_DIR) + "/graphs/" + graph, Registry::instance(), options);
        ASSERT_TRUE(loaded.ok()) << graph;
        Monitor monitor;
        const RunResult result = run_plan(make_plan(loaded.graph), *make_serial_executor(), monitor);
        for (const NodeError& error : result.errors) ADD_FAILURE() << graph << ": " << error.node << ": " << error.message;
        if (!result.ok()) continue;
        const Image picture = read_picture(folder / "out.exr");
        double sum = 0, weighted = 0;
        for (const float x : picture.pixels()) {
            ASSERT_TRUE(std::isfinite(x));
            sum += double(x) / double(picture.pixels().size());
        }
        for (size_t i = 0; i < made.samples.size(); ++i)
            for (size_t c = 0; c < 3; ++c) weighted += double(made.samples.values("weight")[i]) * double(made.samples.rgb()[3 * i + c]) / double(picture.pixels().size());
        EXPECT_NEAR(sum / weighted, 1, 0.03) << graph;
    }
}

}  // namespace
}  // namespace weft
