// Several lights at once, each with a light field of its own; and lights that are meshes.
#include <fmt/format.h>

#include <fstream>
#include <random>
#include <sstream>

#include "render/scene.h"
#include "shadows/fit_light_view_kernel.h"
#include "shadows/light_mesh.h"
#include "tests/graph_run.h"
#include "tests/shadows/shadow_test.h"
#include "tests/shadows/visibility_test.h"

namespace weft {
namespace {

const std::string graphs = std::string(WEFT_SOURCE_DIR) + "/graphs/";

double rmse(const Image& a, const Image& b) {
    double sum = 0;
    for (size_t i = 0; i < a.pixels().size(); ++i)
        sum += std::pow(double(a.pixels()[i] - b.pixels()[i]), 2);
    return std::sqrt(sum / double(a.pixels().size()));
}

// The shipped graph on the shipped scene, with the shadows of these lights.
Image shadows_of(const std::string& lights, int threads = 1, int tile = 32,
                 const std::string& among = "[]") {
    std::stringstream text;
    text << std::ifstream(graphs + "soft-shadows-lights.json").rdbuf();
    return GraphRun(text.str(), tile, threads, true,
                    {"scene=" + graphs + "scenes/shadow-two-lights.json", "lights=" + lights,
                     "among=" + among,
                     "width=120", "height=68", "spp=9", "locations=32", "out=OUT"})
        .picture;
}
// The mean of so many samples of a scene.
Image mean_of(const std::string& scene, int width, int height, int spp) {
    return GraphRun(fmt::format(R"({{"weft": 1, "nodes": {{
        "scene":   {{"type": "read-scene", "set": {{"file": "{}"}}}},
        "render":  {{"type": "render-samples", "in": {{"scene": "scene"}}, "set": {{"width": {}, "height": {}, "spp": {}}}}},
        "picture": {{"type": "pixel-filter", "in": {{"samples": "render"}}}},
        "write":   {{"type": "write-image", "in": {{"image": "picture"}}, "set": {{"file": "OUT", "depth": "float"}}}}}}}})",
                                scene, width, height, spp))
        .picture;
}

TEST(SeveralLights, AreNearerToTheTruthTogetherThanEachAlone) {
    const std::string scene = graphs + "scenes/shadow-two-lights.json";
    const Image truth = mean_of(scene, 120, 68, 512), both = shadows_of(R"(["wide", "narrow"])");
    const double error = rmse(both, truth), input = rmse(mean_of(scene, 120, 68, 9), truth);
    EXPECT_LT(error, 0.45 * input);
    EXPECT_LT(error, rmse(shadows_of(R"(["wide"])"), truth));
    EXPECT_LT(error, rmse(shadows_of(R"(["narrow"])"), truth));
    // In whatever order, and the same bits for any threads and tiles.
    EXPECT_LT(rmse(shadows_of(R"(["narrow", "wide"])"), truth), 0.45 * input);
    EXPECT_EQ(values_of(shadows_of(R"(["wide", "narrow"])", 3, 17)), values_of(both));
}

double mean(const Image& image) {
    double sum = 0;
    for (const float v : image.pixels()) sum += double(v);
    return sum / double(image.pixels().size());
}

// Each location asks one light and counts it for as many as it stands for: the same picture, with
// some noise.
TEST(SeveralLights, AreAskedOneByOneByTheirPower) {
    const std::string scene = graphs + "scenes/shadow-two-lights.json",
                      both = R"(["wide", "narrow"])";
    const Image truth = mean_of(scene, 120, 68, 512), one = shadows_of(both, 1, 32, both),
                all = shadows_of(both);
    EXPECT_LT(rmse(one, truth), 0.5 * rmse(mean_of(scene, 120, 68, 9), truth));
    EXPECT_NEAR(mean(one), mean(all), 0.01 * mean(all));
    EXPECT_NE(values_of(one), values_of(all));
    EXPECT_EQ(values_of(shadows_of(both, 3, 17, both)), values_of(one));
}

// A lamp over a floor, past the edge of a board; the camera looks at the floor from below the board.
//   lamp, mesh   JSON of lights, and of shapes that shine
struct Lamp {
    std::string lights, shapes;
};
const Lamp quad_lamp{
    R"({"shape": "quad", "name": "key", "at": [0, 10, 0], "target": [0, 0, 0], "up": [0, 0, -1], "size": [2, 2], "radiance": [1, 1, 1]})",
    ""};
// The same as two triangles.
const Lamp mesh_lamp{
    "",
    R"(, {"shape": "plane", "name": "key", "material": "lamp", "at": [0, 10, 0], "rotate": [180, 0, 0]})"};

std::string scene_of(const Lamp& lamp, const std::string& board) {
    return fmt::format(R"({{"weft_scene": 1, "shutter": {{"open": 0, "close": 1}},
        "materials": {{"grey": {{"kind": "diffuse", "color": [0.5, 0.5, 0.5]}},
                       "lamp": {{"kind": "diffuse", "color": [0, 0, 0], "emission": [1, 1, 1], "two-sided": false}}}},
        "shapes": [{{"shape": "plane", "material": "grey", "scale": 50}}{}{}],
        "lights": [{}],
        "camera": {{"at": [0, 3, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 7.16}}}})",
                       lamp.shapes, board.empty() ? "" : ", " + board, lamp.lights);
}

SeenShadow lit(const std::string& text, int spp = 16) {
    KnownShadow size;
    size.spp = spp;
    return SeenShadow(text, size);
}

// Columns' means of visibility, root mean square difference.
double column_error(const Image& a, const std::function<double(int)>& exact) {
    double sum = 0;
    for (int x = 0; x < a.width(); ++x) {
        double mean = 0;
        for (int y = 0; y < a.height(); ++y) mean += double(*a.at(x, y)) / a.height();
        sum += std::pow(mean - exact(x), 2) / a.width();
    }
    return std::sqrt(sum);
}

TEST(MeshLights, AreQuadsWhereTheirTrianglesMakeOne) {
    const SeenShadow quad = lit(scene_of(quad_lamp, "")), mesh = lit(scene_of(mesh_lamp, ""));
    EXPECT_EQ(mesh.view.shape, LightView::Shape::mesh);
    EXPECT_TRUE(mesh.view.flat);
    EXPECT_NEAR(mesh.view.ax, quad.view.ax, 1e-6);
    EXPECT_NEAR(mesh.view.ay, quad.view.ay, 1e-6);
    for (const Point3 p : {Point3{0.3, 2, -0.7}, Point3{-1, 0, 4}}) {
        const Point3 q = quad.view.from_world(p, 0.5), m = mesh.view.from_world(p, 0.5);
        EXPECT_NEAR(m.z, q.z, 1e-5);
        EXPECT_NEAR(std::hypot(m.x, m.y), std::hypot(q.x, q.y), 1e-5);
    }
    EXPECT_EQ(mesh.rays.size(), quad.rays.size());
}

// The exact ramp behind an edge, as of a quad: by rays, and for edges and boards of any place.
TEST(MeshLights, CastTheShadowOfTheQuadThatTheyAre) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 4; ++i) {
        const double edge = 0.6 * unit(random) - 0.3, half = 3 * std::tan(3.58 * pi_d / 180) * 8;
        const std::string board = half_plane(edge);
        const auto exact = [&](int x) {
            return past_edge_quad(((x + 0.5) / 64 * 2 - 1) * half, edge, 10, 6);
        };
        EXPECT_LT(column_error(lit(scene_of(quad_lamp, board), 64).bounds("visibility"), exact), 0.012);
        EXPECT_LT(column_error(lit(scene_of(mesh_lamp, board), 64).bounds("visibility"), exact), 0.012)
            << edge;
    }
}

TEST(MeshLights, SpreadTheirPointsByArea) {
    // An L of three squares, as six triangles; the mean of its points is that of its area.
    shadows::WorldMesh mesh;
    for (const auto &[x, y] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}) {
        mesh.open.push_back({Point3{x, y, 3}, {x + 1, y, 3}, {x + 1, y + 1, 3}});
        mesh.open.push_back({Point3{x, y, 3}, {x + 1, y + 1, 3}, {x, y + 1, 3}});
    }
    LightView view;
    view.shape = LightView::Shape::mesh;
    shadows::place_mesh(mesh, {0, 0, 9}, "light", view);
    EXPECT_TRUE(view.flat);
    constexpr int n = 96;
    Point3 mean;
    int in_corner = 0;
    for (int i = 0; i < n * n; ++i) {
        const LightPoint l = view.draw((i % n + 0.5) / n, (i / n + 0.5) / n, {0, 0, 5});
        const Point3 at = view.to_world({view.ax * l.lx, view.ay * l.ly, 0}, 0.5);
        mean = mean + at * (1.0 / (n * n));
        in_corner += at.x < 1 && at.y < 1;
        EXPECT_FALSE(at.x > 1.001 && at.y > 1.001) << at.x << " " << at.y;
        EXPECT_NEAR(at.z, 3, 1e-9);
    }
    EXPECT_NEAR(mean.x, 5.0 / 6, 0.01);
    EXPECT_NEAR(mean.y, 5.0 / 6, 0.01);
    EXPECT_NEAR(double(in_corner) / (n * n), 1.0 / 3, 0.02);
}

// A ball of triangles shadows as a ball does that is given as one.
TEST(MeshLights, AreBallsWhereTheirTrianglesMakeOne) {
    const Lamp ball{R"({"shape": "sphere", "name": "key", "at": [0, 10, 0], "radius": 1, "radiance": [1, 1, 1], "visible": false})", ""};
    const Lamp mesh{"", R"(, {"shape": "sphere", "name": "key", "material": "lamp", "at": [0, 10, 0], "segments": 48})"};
    const std::string board = half_plane(0.1);
    const Image true_ball = lit(scene_of(ball, board), 64).bounds("visibility");
    const SeenShadow made = lit(scene_of(mesh, board), 64);
    EXPECT_FALSE(made.view.flat);
    EXPECT_EQ(made.rays.size(), made.samples.size());
    EXPECT_LT(column_error(made.bounds("visibility"),
                           [&](int x) {
                               double mean = 0;
                               for (int y = 0; y < 8; ++y) mean += double(*true_ball.at(x, y)) / 8;
                               return mean;
                           }),
              0.015);
}

TEST(MeshLights, MoveAsAWhole) {
    const std::string speed = R"("velocity": [0.8, 0, 0], )";
    Lamp quad = quad_lamp, mesh = mesh_lamp;
    quad.lights.insert(1, speed);
    mesh.shapes.insert(mesh.shapes.find("\"shape\""), speed);
    const std::string board = half_plane(0);
    const SeenShadow still = lit(scene_of(quad, board), 64), made = lit(scene_of(mesh, board), 64);
    EXPECT_TRUE(made.view.moves);
    EXPECT_FALSE(made.rays.motion().empty());
    const Image known = still.bounds("visibility");
    EXPECT_LT(column_error(made.bounds("visibility"),
                           [&](int x) {
                               double mean = 0;
                               for (int y = 0; y < 8; ++y) mean += double(*known.at(x, y)) / 8;
                               return mean;
                           }),
              0.015);
    shadows::WorldMesh bent;
    bent.open = {{Point3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {Point3{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
    bent.close = bent.open;
    bent.close[1][1].z = 0.5;
    LightView view;
    EXPECT_NE(error_of([&] { shadows::place_mesh(bent, {}, "light 'key'", view); })
                  .find("light 'key' changes shape"),
              std::string::npos);
    for (auto& corners : bent.open) corners = {};
    EXPECT_NE(error_of([&] { shadows::place_mesh(bent, {}, "light 'key'", view); })
                  .find("none of the 2 triangles"),
              std::string::npos);
}

TEST(MeshLights, SayWhatIsMissing) {
    const auto error = [](const std::string& meta) {
        Samples samples = lit(scene_of(mesh_lamp, ""), 1).samples;
        samples.meta.set("lights", parse_json_or_throw(meta, "meta"));
        return error_of([&] {
            RunNode("fit-light-view").in("samples", samples).out<LightView>("light-view");
        });
    };
    const std::string mesh = R"([{"name": "key", "shape": "mesh", "triangles": )";
    EXPECT_NE(error(mesh + "[]}]").find("light 'key' is a mesh without 'triangles'"),
              std::string::npos);
    EXPECT_NE(error(mesh + "[[1, 2, 3]]}]").find("expected 9 numbers"), std::string::npos);
    const std::string one = "[[0, 9, 0, 1, 9, 0, 0, 9, 1]]";
    EXPECT_NE(error(mesh + one + R"(, "triangles_end": []}])").find("expected as many"),
              std::string::npos);
    EXPECT_NE(error(mesh + one + R"(, "chances": [1, 2]}])").find("expected 1 numbers"),
              std::string::npos);
    // Its corners go the other way round seen from below: it shines up.
    EXPECT_NE(error(mesh + "[[0, 9, 0, 0, 9, 1, 1, 9, 0]]}]").find("in front of light 'key'"),
              std::string::npos);
    EXPECT_EQ(error(mesh + one + "}]"), "");
    const Lamp fine{"", R"(, {"shape": "sphere", "name": "key", "material": "lamp", "at": [0, 10, 0], "segments": 128})"};
    EXPECT_NE(error_of([&] { lit(scene_of(fine, ""), 1); }).find("writes up to 4096"),
              std::string::npos);
}

// Of lamp and mesh by area and radiance: here two squares, one of them twice as bright.
TEST(SeveralLights, HaveThePowerThatTheRendererTakesThemFor) {
    std::string scene = scene_of({quad_lamp.lights, mesh_lamp.shapes}, "");
    scene.replace(scene.find("\"radiance\": [1, 1, 1]"), 21, "\"radiance\": [2, 2, 2]");
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << scene;
    const Samples samples = RunNode("render-samples")
                                .in("scene", RunNode("read-scene").set("file", file).out<Scene>("scene"))
                                .set("width", 64)
                                .set("height", 32)
                                .set("spp", 16)
                                .set("channels", Json::list({"basic", "light_index"}))
                                .out<Samples>("samples");
    EXPECT_NEAR(shadows::light_power(samples, "0"), 2 * shadows::light_power(samples, "1"), 1e-4);
    const auto& index = samples.find("light_index")->ids;
    double first = 0;
    for (size_t i = 0; i < samples.size(); ++i) first += index[i] == 0;
    EXPECT_NEAR(first / double(samples.size()), 2.0 / 3, 0.02);
}

TEST(SeveralLights, SayWhichOfThemIsMissing) {
    const auto error = [](const std::string& among) {
        LoadOptions load;
        load.overrides.set = {"scene=" + graphs + "scenes/shadow-two-lights.json", "width=16",
                              "height=10", "locations=4", "among=" + among};
        const Loaded loaded = load_graph(graphs + "soft-shadows-lights.json", Registry::instance(), load);
        Monitor monitor;
        const RunResult result = run_plan(make_plan(loaded.graph), *make_serial_executor(), monitor);
        return result.errors.empty() ? std::string() : result.errors[0].message;
    };
    EXPECT_NE(error(R"(["wide"])").find("light 'narrow' is not one of 'lights'"), std::string::npos)
        << error(R"(["wide"])");
    EXPECT_NE(error(R"(["wide", "narrow", "third"])").find("no light 'third'"), std::string::npos);
}

TEST(SeveralLights, AreFoundByNameAndByNumber) {
    const Lamp both{quad_lamp.lights, mesh_lamp.shapes};
    const Samples samples = lit(scene_of(both, ""), 1).samples;
    const auto shape = [&](const std::string& light) {
        return RunNode("fit-light-view")
            .set("light", light)
            .in("samples", samples)
            .out<LightView>("light-view")
            .shape;
    };
    EXPECT_EQ(shape("0"), LightView::Shape::quad);
    EXPECT_EQ(shape("1"), LightView::Shape::mesh);
    EXPECT_EQ(shape("key"), LightView::Shape::quad);
    EXPECT_NE(error_of([&] { shape("2"); }).find("no light '2'"), std::string::npos);
}

// The whole row: as near to the truth as that of the same quad.
TEST(MeshLights, AreReconstructedAsQuadsAre) {
    TestFolder folder;
    const std::string file = folder / "scene.json", board = half_plane(0);
    std::stringstream text;
    text << std::ifstream(graphs + "soft-shadows-light-field.json").rdbuf();
    const auto run = [&](const Lamp& lamp) {
        std::ofstream(file) << scene_of(lamp, board);
        return GraphRun(text.str(), 32, 1, true,
                        {"scene=" + file, "width=64", "height=16", "spp=16", "locations=64",
                         "out=OUT"})
            .picture;
    };
    const Image from_quad = run(quad_lamp), from_mesh = run(mesh_lamp);
    const Image truth = mean_of(file, 64, 16, 1024);
    const double input = rmse(mean_of(file, 64, 16, 16), truth), error = rmse(from_mesh, truth);
    EXPECT_LT(error, 0.6 * input);
    EXPECT_LT(error, 1.25 * rmse(from_quad, truth));
    // From recorded rays alone, too.
    std::stringstream seven;
    seven << std::ifstream(graphs + "tlfr-7d.json").rdbuf();
    const Image recorded = GraphRun(seven.str(), 32, 1, true,
                                    {"scene=" + file, "width=64", "height=16", "spp=16",
                                     "locations=64", "out=OUT"})
                               .picture;
    EXPECT_LT(rmse(recorded, truth), 0.6 * input);
}

}  // namespace
}  // namespace weft
