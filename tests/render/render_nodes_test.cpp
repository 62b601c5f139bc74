// The nodes: the same bits however samples are made and handed on, adaptive buffers, memory said
// beforehand, stopping rules.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "image/image.h"
#include "render/procedural_scene.h"
#include "render/render_test.h"
#include "run_node.h"
#include "runtime/registry.h"
#include "runtime/run.h"
#include "samples/sample_file.h"

namespace weft::render {
namespace {

void expect_equal(const Samples& a, const Samples& b) {
    ASSERT_EQ(a.size(), b.size());
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (const Channel& c : a.channels) {
        const Channel* other = b.find(c.name);
        ASSERT_TRUE(other) << c.name;
        ASSERT_EQ(c.components, other->components);
        if (c.whole())
            EXPECT_TRUE(
                std::equal(c.ids.view().begin(), c.ids.view().end(), other->ids.view().begin()))
                << c.name;
        else
            EXPECT_EQ(std::memcmp(c.values.view().data(), other->values.view().data(),
                                  c.values.view().size_bytes()),
                      0)
                << c.name;
    }
}

// One graph run: samples to a file, in whole or in tiles, and a picture of them.
struct Made {
    Samples samples;
    std::vector<float> picture;
};
Made run(const std::string& scene, bool tiles, Executor& executor, int tile,
         const std::string& folder, bool wide = false) {
    const std::string file = folder + (tiles ? "/tiles.npz" : "/whole.npz"),
                      picture = folder + (tiles ? "/tiles.exr" : "/whole.exr");
    const std::string set = R"("set": {"width": 50, "height": 37, "spp": 9, "channels": ["all"]})";
    const std::string filter = wide ? R"(, "set": {"filter": "gaussian"})" : "";
    const std::string text = R"({"weft": 1, "nodes": {
        "scene": {"type": "procedural-scene", "set": {"name": ")" +
                             scene + R"("}},
        "render": {"type": ")" +
                             std::string(tiles ? "render-tiles" : "render-samples") +
                             R"(", "in": {"scene": "scene"}, )" + set + R"(},
        "picture": {"type": ")" +
                             std::string(tiles ? "filter-tiles" : "pixel-filter") +
                             R"(", "in": {"samples": "render"})" + filter + R"(},
        "image": {"type": "write-image", "in": {"image": "picture.image"}, "set": {"file": ")" +
                             picture + R"(", "depth": "float"}},
        "write": {"type": ")" +
                             std::string(tiles ? "write-tiles" : "write-samples") +
                             R"(", "in": {"samples": "render"}, "set": {"file": ")" + file +
                             R"("}}}})";
    const Loaded loaded = load_graph_text(text, "test.json", Registry::instance());
    for (const Diagnostic& finding : loaded.findings) ADD_FAILURE() << to_text(finding);
    const Plan plan = make_plan(loaded.graph);
    Monitor monitor;
    RunOptions options;
    options.tile = tile;
    const RunResult result = run_plan(plan, executor, monitor, options);
    for (const NodeError& error : result.errors) ADD_FAILURE() << error.message;
    PlainContext ctx;
    Made out;
    ReadOptions all;
    all.channels = {"*"};
    out.samples = read_sample_file(map_file(file), all, ctx);
    const Image image = RunNode("read-image").set("file", Json(picture)).out<Image>("image");
    out.picture.assign(image.pixels().begin(), image.pixels().end());
    return out;
}

TEST(RenderNodes, give_the_same_bits_for_any_threads_tiles_and_batches) {
    for (const std::string scene : {"motion", "occluders", "cornell"}) {
        TestFolder folder;
        const Made one = run(scene, false, *make_tbb_executor(1), 32, folder.path());
        EXPECT_GT(one.samples.channels.size(), 25u);
        for (const auto& [threads, tile] : {std::pair{2, 32}, std::pair{7, 11}}) {
            expect_equal(
                run(scene, false, *make_thread_executor(threads), tile, folder.path()).samples,
                one.samples);
            const Made tiles = run(scene, true, *make_tbb_executor(threads), tile, folder.path());
            expect_equal(tiles.samples, one.samples);
            EXPECT_EQ(tiles.picture, one.picture);
        }
    }
}

TEST(RenderNodes, a_wide_filter_on_tiles_is_that_on_samples) {
    TestFolder folder;
    const Made whole = run("cornell", false, *make_serial_executor(), 32, folder.path(), true);
    const Made tiles = run("cornell", true, *make_serial_executor(), 13, folder.path(), true);
    const Made others = run("cornell", true, *make_thread_executor(3), 32, folder.path(), true);
    EXPECT_EQ(tiles.picture, others.picture);
    ASSERT_EQ(tiles.picture.size(), whole.picture.size());
    for (size_t i = 0; i < whole.picture.size(); ++i)
        ASSERT_NEAR(tiles.picture[i], whole.picture[i], 1e-4f * (1 + whole.picture[i]));
}

TEST(RenderNodes, counts_make_a_buffer_adaptive) {
    const Scene scene = procedural_scene("cornell");
    Image counts(20, 12, 1);
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 20; ++x) counts.at(x, y)[0] = float((3 * x + 5 * y) % 23);
    const Samples s =
        RunNode("render-samples").in("scene", scene).in("counts", counts).out<Samples>("samples");
    EXPECT_EQ(s.spp, 0);
    ASSERT_EQ(s.width, 20);
    for (size_t pixel = 0; pixel < s.pixels(); ++pixel) {
        const auto range = s.of_pixel(pixel);
        const int x = int(pixel % 20), y = int(pixel / 20);
        ASSERT_EQ(range.end - range.begin, size_t((3 * x + 5 * y) % 23));
        for (size_t i = range.begin; i < range.end; ++i) {
            ASSERT_EQ(int(s.xy()[2 * i]), x);
            ASSERT_EQ(int(s.xy()[2 * i + 1]), y);
        }
    }
    counts.at(3, 2)[0] = -1;
    EXPECT_NE(error_of([&] {
                  RunNode("render-samples")
                      .in("scene", scene)
                      .in("counts", counts)
                      .out<Samples>("samples");
              }).find("-1 samples in pixel (3, 2)"),
              std::string::npos);
}

TEST(RenderNodes, say_what_they_need_before_they_run) {
    const NodeType* type = Registry::instance().type("render-samples");
    std::vector<Json> params(type->decl().params.size());
    const auto set = [&](const std::string& name, Json value) {
        for (size_t i = 0; i < params.size(); ++i)
            if (type->decl().params[i].name == name) params[i] = std::move(value);
    };
    set("width", Json(1920)), set("height", Json(1080)), set("spp", Json(16));
    const Cost cost = type->make(params)->cost({});
    EXPECT_EQ(cost.outputs[0].second.bytes, 1920.0 * 1080 * 16 * 4 * 13);
    set("channels", Json::list({"basic", "nomal"}));
    EXPECT_NE(error_of([&] {
                  type->make(params)->cost({});
              }).find("no channel 'nomal'; there are basic, all, xy"),
              std::string::npos);
}

TEST(RenderNodes, meta_tells_lens_shutter_lights_and_camera) {
    Scene scene = procedural_scene("chess");
    scene.camera.blades = 7;
    scene.camera.shutter_curve = {0, 1, 1, 0};
    const Samples s = RunNode("render-samples")
                          .set("width", Json(8))
                          .set("height", Json(6))
                          .set("spp", Json(1))
                          .in("scene", scene)
                          .out<Samples>("samples");
    const Json meta = s.meta_object();
    EXPECT_EQ(meta.find("lens")->find("blades")->number, 7);
    EXPECT_EQ(meta.find("shutter_curve")->items.size(), 4u);
    EXPECT_EQ(meta.find("lights")->items.size(), scene.lights.size());
    EXPECT_EQ(meta.find("camera")->find("world_to_camera")->items.size(), 4u);
    EXPECT_NE(meta.find("source")->text.find("chess"), std::string::npos);
}

TEST(RenderNodes, an_image_comes_with_its_own_error) {
    Scene scene = procedural_scene("cornell");
    const auto render = [&](int spp, double error, const char* port, std::uint64_t seed = 1) {
        return RunNode("render-image")
            .set("width", Json(24))
            .set("height", Json(24))
            .set("spp", Json(spp))
            .set("sampler", Json("independent"))
            .set("relative-error", Json(error))
            .set("max-depth", Json(1))
            .set("seed", Json(double(seed)))
            .in("scene", scene)
            .out<Image>(port);
    };
    const Image image = render(64, 0, "image"), variance = render(64, 0, "variance"),
                a = render(64, 0, "half-a"), b = render(64, 0, "half-b");
    const Image other = render(64, 0, "image", 2);
    double between = 0, halves = 0, n = 0;
    for (size_t i = 0; i < image.pixels().size(); ++i) {
        ASSERT_NEAR(image.pixels()[i], 0.5f * (a.pixels()[i] + b.pixels()[i]),
                    1e-5f * (1 + image.pixels()[i]));
        const double v = double(variance.pixels()[i]);
        if (!(v > 1e-8)) continue;
        between += std::pow(double(image.pixels()[i] - other.pixels()[i]), 2) / (2 * v);
        halves += std::pow(double(a.pixels()[i] - b.pixels()[i]), 2) / (4 * v);
        ++n;
    }
    EXPECT_GT(n, 500);
    EXPECT_NEAR(between / n, 1, 0.25);
    EXPECT_NEAR(halves / n, 1, 0.25);
    // A rule that holds at once stops after a pass of 16; one that never does warns.
    EXPECT_EQ(render(640, 5, "image").pixels()[5], render(16, 0, "image").pixels()[5]);
    RunNode never("render-image");
    never.set("width", Json(8))
        .set("height", Json(8))
        .set("spp", Json(16))
        .set("relative-error", Json(1e-6))
        .in("scene", scene)
        .out<Image>("image");
    ASSERT_EQ(never.ctx.warnings.size(), 1u);
    EXPECT_NE(never.ctx.warnings[0].find("raise 'spp'"), std::string::npos);
}

TEST(RenderNodes, ambient_occlusion_is_one_in_the_open_and_less_in_a_corner) {
    Scene scene;
    scene.materials = {diffuse(0.2f)};
    scene.meshes = {floor_mesh(50)};
    // A floor and a wall at right angles: at the edge half of the sky is gone.
    scene.instances = {placed(0), placed(0, {rotate({0, 0, 1}, pi / 2)}, 2)};
    const auto seen = [&](float x) {
        scene.camera = camera_at({x, 6, 0}, {x, 0, 0}, 0.1f, {0, 0, -1});
        RenderOptions o;
        o.width = o.height = 4;
        o.mode = Mode::ambient_occlusion;
        return estimate(render_scene(scene, o, 1024, {"basic"}).rgb(), 3).mean;
    };
    EXPECT_NEAR(seen(0.01f), 0.5, 0.02);
    EXPECT_GT(seen(45), 0.9 * 0.5);
    scene.instances.pop_back();
    EXPECT_NEAR(seen(0.01f), 1, 1e-6);
}

// 1000 times 10 000 triangles: one mesh in memory.
TEST(RenderNodes, ten_million_instanced_triangles_stay_small) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {ball_mesh(51, true)};
    ASSERT_GT(scene.meshes[0].triangles.size() * 1000, 10000000u);
    for (int i = 0; i < 1000; ++i)
        scene.instances.push_back(placed(
            0, {translate({float(i % 10) * 3, float(i / 10 % 10) * 3, float(i / 100) * 3})}));
    scene.environment.radiance = {1, 1, 1};
    scene.camera = camera_at({40, 40, 50}, {13, 13, 13}, 40);
    EXPECT_GT(scene.placed_triangles(), 10000000u);
    RenderOptions o;
    o.width = 64, o.height = 36;
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    const Samples s = render_scene(scene, o, 1, {"basic"});
    getrusage(RUSAGE_SELF, &after);
    EXPECT_GT(estimate(s.values("alpha")).mean, 0.2);
    EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 100 * 1024);  // kB
}

}  // namespace
}  // namespace weft::render
