// The JSON scene form: what its members do, and the places and words of its errors.
#include <cmath>
#include <fstream>

#include "render/affine.h"
#include "render/check_scene.h"
#include "render/gltf_maker.h"
#include "render/procedural_scene.h"
#include "render/scene_file.h"
#include "run_node.h"

namespace weft {
namespace {

std::vector<std::string> warnings;

Scene read(const std::string& text, const std::string& path = "test.json") {
    warnings.clear();
    Scene scene = json_scene(text, path, {}, warnings);
    check_scene(scene);
    return scene;
}

TEST(JsonScene, ShapesLightsAndALens) {
    const Scene scene = read(R"({"weft_scene": 1,
        "shutter": {"open": 1, "close": 1.5, "curve": [0, 1, 1, 0]},
        "materials": {"gold": {"kind": "conductor", "color": [1, 0.8, 0.4], "roughness": 0.1}},
        "shapes": [{"shape": "sphere", "material": "gold", "at": [0, 1, 0], "scale": 0.5, "velocity": [2, 0, 0]},
                   {"shape": "cube", "grid": {"count": [3, 1, 2], "step": [2, 0, 4]}}],
        "lights": [{"shape": "quad", "at": [0, 4, 0], "size": [2, 1], "radiance": 10},
                   {"shape": "disc", "at": [1, 2, 0], "target": [0, 0, 0], "radius": 0.25},
                   {"shape": "sphere", "at": [3, 3, 3], "radius": 0.1, "radiance": [5, 5, 4]},
                   {"shape": "directional", "at": [1, 1, 0], "irradiance": 3}],
        "environment": {"color": [0.5, 0.6, 0.7], "strength": 2, "rotation": 90},
        "camera": {"at": [0, 1, 5], "target": [0, 1, 0], "fov": 40,
                   "lens": {"f-number": 2, "sensor": 24, "blades": 6, "blade-rotation": 15, "squeeze": 2}}})");
    EXPECT_EQ(scene.instances.size(), 7u);
    EXPECT_EQ(scene.meshes.size(), 2u);  // the cubes share one
    EXPECT_EQ(scene.materials[size_t(scene.instances[0].material)].kind, Material::Kind::conductor);
    const auto& keys = scene.instances[0].to_world;
    ASSERT_EQ(keys.size(), 2u);  // half a second at 2 a second
    EXPECT_NEAR(keys[1].origin.x - keys[0].origin.x, 1, 1e-6);
    EXPECT_EQ(scene.instances[1].to_world[0].origin, (Vec3{-2, 0, -2}));
    ASSERT_EQ(scene.lights.size(), 4u);
    EXPECT_NEAR(scene.lights[0].to_world[0].z.y, 1, 1e-6);  // shines down
    EXPECT_NEAR(length(scene.lights[0].to_world[0].x), 1, 1e-6);
    EXPECT_EQ(scene.lights[0].radiance, (Vec3{10, 10, 10}));
    EXPECT_NEAR(scene.lights[3].to_world[0].z.x, std::sqrt(0.5), 1e-5);
    EXPECT_EQ(scene.environment.radiance, (Vec3{1, 1.2f, 1.4f}));
    const SceneCamera& c = scene.camera;
    EXPECT_NEAR(c.focus, 5, 1e-5);  // at the target
    // Focal length 12 mm / tan(20 degrees) = 32.97 mm; radius = f / (2 N).
    EXPECT_NEAR(c.lens_radius, 0.03297 / 4, 1e-5);
    EXPECT_EQ(c.blades, 6);
    EXPECT_EQ(c.lens_aspect, 2);
    EXPECT_EQ(c.shutter_curve, (std::vector<float>{0, 1, 1, 0}));
    EXPECT_TRUE(warnings.empty());
}

TEST(JsonScene, IncludesPlacesAndOverridesParts) {
    TestFolder folder;
    GltfMaker m;
    m.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
    std::ofstream(folder / "two.gltf") << m.text(
        R"("nodes":[{"mesh":0,"name":"left"},{"mesh":0,"name":"right"},{"camera":0,"translation":[0,0,2]}],)"
        R"("cameras":[{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])");
    const Scene scene = read(R"({"weft_scene": 1, "shutter": {"open": 0, "close": 1},
        "materials": {"red": {"color": [1, 0, 0]}},
        "include": [{"file": "two.gltf", "at": [10, 0, 0], "override": {"left": {"material": "red", "spin": {"axis": [0, 0, 1], "turns": 0.5}},
                                                                       "r*": {"hide": true}}},
                    {"file": "two.gltf", "name": "again", "rotate": [0, 90, 0], "velocity": [0, 1, 0]}]})",
                             folder / "s.json");
    EXPECT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.instances.size(), 3u);
    EXPECT_EQ(scene.materials[size_t(scene.instances[0].material)].name, "red");
    EXPECT_GE(scene.instances[0].to_world.size(), 4u);  // half a turn
    EXPECT_EQ(scene.instances[1].name, "again/left");
    EXPECT_NEAR(scene.instances[1].to_world[0].point({1, 0, 0}).z, -1, 1e-5);
    EXPECT_NEAR(scene.instances[2].to_world.back().origin.y, 1, 1e-6);
    EXPECT_EQ(scene.camera.vertical_fov, 0.5f);  // of the first include
    EXPECT_EQ(scene.camera.to_world[0].origin, (Vec3{10, 0, 2}));
}

TEST(JsonScene, ErrorsHavePlacesAndSuggestions) {
    const std::string found = error_of([] {
        read(
            "{\"weft_scene\": 1,\n \"shapes\": [{\"shape\": \"spere\", \"material\": \"glod\", "
            "\"att\": [0, 0, 0]}],\n"
            " \"materials\": {\"gold\": {\"roughness\": 3}},\n \"lights\": [{\"radiance\": -1}, "
            "{\"size\": [0, 1]}],\n"
            " \"camera\": {\"lens\": {\"blades\": 2}, \"fov\": \"wide\"}}");
    });
    for (const char* expected :
         {"test.json:2:23: no shape 'spere'; did you mean 'sphere'?",
          "test.json:2:44: no material 'glod'; did you mean 'gold'?",
          "a shape has no 'att'; did you mean 'at'?",
          "test.json:3:38: 'roughness' is 3; expected 0 to 1", "'radiance' is -1; expected 0 to",
          "'size' is not above 0", "'blades' is 1 or 2; expected 0 (round) or 3 to 64",
          "'fov' is a text; expected a number"})
        EXPECT_NE(found.find(expected), std::string::npos) << expected << "\nin\n" << found;
    EXPECT_EQ(error_of([] { read("{\"weft_scene\": 2}"); }),
              "test.json:1:16: \"weft_scene\" is 2; this program reads 1");
    EXPECT_NE(error_of([] { read("{}"); }).find("not a scene"), std::string::npos);
    EXPECT_NE(error_of([] { read("{\"weft_scene\": 1}"); }).find("nothing to see"),
              std::string::npos);
    EXPECT_NE(error_of([] { read("{\"weft_scene\": 1,"); }).find("test.json:1:"),
              std::string::npos);
    EXPECT_NE(error_of([] {
                  read(R"({"weft_scene":1,"include":[{"file":"gone.gltf"}]})");
              }).find("no file 'gone.gltf'"),
              std::string::npos);
    EXPECT_NE(error_of([] {
                  read(R"({"weft_scene":1,"include":[{"file":"../scenes/room/a.obj"}]})");
              }).find("run tools/scenes"),
              std::string::npos);
}

TEST(JsonScene, FilesThatIncludeThemselvesEnd) {
    TestFolder folder;
    std::ofstream(folder / "a.json") << R"({"weft_scene":1,"include":[{"file":"a.json"}]})";
    std::vector<std::string> told;
    EXPECT_NE(
        error_of([&] { read_scene_file(folder / "a.json", {}, told); }).find("more than 8 deep"),
        std::string::npos);
}

TEST(ReadScene, TellsWhatItCannotRead) {
    std::vector<std::string> told;
    const auto says = [&](const std::string& path) {
        return error_of([&] { read_scene_file(path, {}, told); });
    };
    EXPECT_EQ(says("scenes/room.json"),
              "scenes/room.json: no such scene file; tools/scenes fetches the scenes that are not "
              "made by rule");
    EXPECT_NE(says(std::string(300, 'x') + ".obj").find("no such scene file"), std::string::npos);
    EXPECT_EQ(says("procedural:ches"), "procedural:ches: no such scene; did you mean 'chess'?");
    EXPECT_EQ(says("procedural:"),
              "procedural:: no such scene; known: leaves, chess, motion, "
              "occluders, cornell");
    TestFolder folder;
    std::ofstream(folder / "a.fbx") << "something";
    EXPECT_NE(says(folder / "a.fbx").find("not a scene that can be read; expected glTF"),
              std::string::npos);
    EXPECT_EQ(RunNode("read-scene").set("file", "procedural:cornell").out<Scene>("scene").name,
              "cornell");
}

TEST(ReadScene, AProceduralSceneTakesSeedAndSize) {
    const auto made = [](const std::string& name, int seed, double size) {
        return RunNode("read-scene")
            .set("file", "procedural:" + name)
            .set("seed", Json(seed))
            .set("size", Json(size))
            .out<Scene>("scene");
    };
    const Scene here = made("leaves", 3, 0.25), there = procedural_scene("leaves", 3, 0.25f);
    EXPECT_EQ(here.source, "procedural:leaves, seed 3, size 0.25");
    ASSERT_EQ(here.instances.size(), there.instances.size());
    EXPECT_EQ(here.instances.back().to_world, there.instances.back().to_world);
    EXPECT_NE(here.instances.back().to_world,
              procedural_scene("leaves", 4, 0.25f).instances.back().to_world);
    // A file has neither, and a scene made by rule no cameras to choose from.
    TestFolder folder;
    std::ofstream(folder / "a.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const std::string file = folder / "a.obj";
    const auto says = [](RunNode&& node) { return error_of([&] { node.out<Scene>("scene"); }); };
    EXPECT_EQ(says(std::move(RunNode("read-scene").set("file", Json(file)))), "");
    EXPECT_EQ(says(std::move(RunNode("read-scene").set("file", Json(file)).set("seed", Json(2)))),
              file +
                  ": 'seed' and 'size' make procedural:NAME scenes; a file is as it is: leave "
                  "them at 1");
    EXPECT_EQ(says(std::move(
                  RunNode("read-scene").set("file", "procedural:chess").set("camera", "left"))),
              "procedural:chess: 'camera' and 'animation' choose among a file's; a scene made by "
              "rule has one camera and moves as it does: leave them empty");
}

TEST(ReadScene, KnowsEveryFileThatItReads) {
    TestFolder folder;
    std::filesystem::create_directory(folder / "part");
    std::ofstream(folder / "all.json")
        << R"({"weft_scene":1,"include":[{"file":"part/a.obj"},{"file":"b.gltf"}],"environment":{"file":"sky.exr"}})";
    std::ofstream(folder / "part/a.obj") << "mtllib my materials.mtl\n";
    std::ofstream(folder / "part/my materials.mtl") << "newmtl m\nmap_Kd -s 1 1 1 wood.png\r\n";
    std::ofstream(folder / "b.gltf")
        << R"({"images":[{"uri":"a%20b.png"}],"buffers":[{"uri":"gone.bin"}]})";
    for (const char* name : {"part/wood.png", "a b.png", "sky.exr"})
        std::ofstream(folder / name) << "x";
    std::vector<std::string> files = scene_files(folder / "all.json");
    EXPECT_EQ(files.front(), folder / "all.json");
    std::sort(files.begin(), files.end());
    std::vector<std::string> expected;
    for (const char* name : {"a b.png", "all.json", "b.gltf", "part/a.obj", "part/my materials.mtl",
                             "part/wood.png", "sky.exr"})
        expected.push_back(folder / name);
    EXPECT_EQ(files, expected);
    EXPECT_TRUE(scene_files("procedural:chess").empty());
}

// The first example of docs/scenes.md.
TEST(JsonScene, TheGuidesExampleIsAScene) {
    const std::string guide = std::string(WEFT_SOURCE_DIR) + "/docs/scenes.md";
    std::ifstream file(guide);
    ASSERT_TRUE(file) << guide;
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const size_t begin = text.find("```json\n"), end = text.find("```", begin + 8);
    ASSERT_NE(begin, std::string::npos);
    const Scene scene = read(text.substr(begin + 8, end - begin - 8));
    EXPECT_GT(scene.instances.size(), 2u);
    EXPECT_GT(scene.camera.lens_radius, 0);
}

}  // namespace
}  // namespace weft
