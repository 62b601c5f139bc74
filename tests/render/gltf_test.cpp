// glTF: meshes, hierarchy, materials, lights, cameras, motion; and what is said of broken files.
#include <cmath>
#include <fstream>

#include "image/png_file.h"
#include "render/affine.h"
#include "render/check_scene.h"
#include "render/gltf_maker.h"
#include "render/keyed_motion.h"
#include "render/scene_file.h"
#include "run_node.h"

namespace weft {
namespace {

std::vector<std::string> warnings;

Scene read(const std::string& bytes, const SceneOptions& options = {}) {
    warnings.clear();
    Scene scene = gltf_scene(bytes, "test.gltf", options, warnings);
    check_scene(scene);
    return scene;
}

// A triangle at accessors 0 (positions) and 1 (indices), placed by `rest`.
struct Triangle : GltfMaker {
    int positions = floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
    int indices = shorts({0, 1, 2});
};
const std::string one_node =
    R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])";

TEST(Gltf, ATriangleAsTextAndAsGlb) {
    const Triangle t;
    for (const std::string& bytes : {t.text(one_node), t.glb(one_node)}) {
        const Scene scene = read(bytes);
        ASSERT_EQ(scene.meshes.size(), 1u);
        EXPECT_EQ(scene.meshes[0].positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
        EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
        EXPECT_TRUE(scene.meshes[0].normals.empty());  // flat
        ASSERT_EQ(scene.instances.size(), 1u);
        EXPECT_EQ(scene.instances[0].to_world.size(), 1u);
        ASSERT_EQ(warnings.size(), 1u);  // no camera
    }
}

TEST(Gltf, StripsAndFansTurnTheRightWay) {
    GltfMaker m;
    m.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, "VEC3");
    m.floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
    const Scene scene = read(m.text(
        R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":5},{"attributes":{"POSITION":1},"mode":6}]}])"));
    ASSERT_EQ(scene.meshes.size(), 2u);
    for (const Mesh& mesh : scene.meshes) {
        ASSERT_EQ(mesh.triangles.size(), 2u);
        for (const auto& t : mesh.triangles) {
            const Vec3 a = mesh.positions[t[0]];
            EXPECT_GT(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a).z, 0);
        }
    }
}

TEST(Gltf, NodesAreFlattenedAndMeshesShared) {
    const Triangle t;
    const Scene scene = read(t.text(
        R"("nodes":[{"children":[1,2],"translation":[1,0,0],"scale":[2,2,2]},{"mesh":0,"translation":[0,1,0]},)"
        R"({"mesh":0,"rotation":[0,0,0.70710678,0.70710678]}],"scenes":[{"nodes":[0]}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])"));
    EXPECT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.instances.size(), 2u);
    EXPECT_EQ(scene.instances[0].to_world[0].origin, (Vec3{1, 2, 0}));
    const Vec3 p = scene.instances[1].to_world[0].point({1, 0, 0});
    EXPECT_NEAR(p.x, 1, 1e-5);
    EXPECT_NEAR(p.y, 2, 1e-5);
    EXPECT_NE(scene.instances[0].id, scene.instances[1].id);
}

TEST(Gltf, MaterialsAndTextures) {
    Triangle t;
    const int uv = t.floats({0, 0, 1, 0, 0, 1}, "VEC2");
    EXPECT_EQ(uv, 2);
    std::vector<std::string> ignored;
    const int view = t.bytes_view(encode_png(Image(2, 2, 3), {}, ignored));
    const Scene scene = read(t.glb(fmt::format(
        R"("nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":2}},"indices":1,"material":0}}]}}],)"
        R"("images":[{{"bufferView":{},"mimeType":"image/png"}}],"samplers":[{{"wrapS":33071,"wrapT":33648}}],"textures":[{{"source":0,"sampler":0}}],)"
        R"("materials":[{{"name":"m","doubleSided":true,"alphaMode":"MASK","alphaCutoff":0.25,"emissiveFactor":[1,0.5,0],)"
        R"("pbrMetallicRoughness":{{"baseColorFactor":[0.1,0.2,0.3,0.9],"metallicFactor":0.25,"roughnessFactor":0.75,)"
        R"("baseColorTexture":{{"index":0,"extensions":{{"KHR_texture_transform":{{"offset":[0.5,0.25],"scale":[2,3],"rotation":1}}}}}},)"
        R"("metallicRoughnessTexture":{{"index":0}}}},"normalTexture":{{"index":0,"scale":0.5}},)"
        R"("extensions":{{"KHR_materials_emissive_strength":{{"emissiveStrength":10}},"KHR_materials_ior":{{"ior":1.33}},"KHR_materials_transmission":{{"transmissionFactor":0.4}}}}}}])",
        view)));
    const Material& m = scene.materials.at(size_t(scene.meshes[0].material));
    EXPECT_EQ(m.name, "m");
    EXPECT_NEAR(m.base_color.y, 0.2, 1e-6);
    EXPECT_NEAR(m.opacity, 0.9, 1e-6);
    EXPECT_EQ(m.metallic, 0.25f);
    EXPECT_EQ(m.roughness, 0.75f);
    EXPECT_EQ(m.emission, (Vec3{10, 5, 0}));
    EXPECT_NEAR(m.ior, 1.33, 1e-6);
    EXPECT_NEAR(m.transmission, 0.4, 1e-6);
    EXPECT_EQ(m.alpha, Material::Alpha::mask);
    EXPECT_EQ(m.alpha_cutoff, 0.25f);
    EXPECT_TRUE(m.two_sided);
    EXPECT_EQ(m.base_color_map.offset, (Vec2{0.5f, 0.25f}));
    EXPECT_EQ(m.base_color_map.scale, (Vec2{2, 3}));
    EXPECT_EQ(m.base_color_map.rotation, 1);
    EXPECT_EQ(m.base_color_map.wrap_u, TextureMap::Wrap::clamp);
    EXPECT_EQ(m.base_color_map.wrap_v, TextureMap::Wrap::mirror);
    EXPECT_EQ(m.normal_scale, 0.5f);
    // One picture, as colours and as numbers.
    ASSERT_EQ(scene.textures.size(), 2u);
    EXPECT_TRUE(scene.textures[size_t(m.base_color_map.file)].color);
    EXPECT_FALSE(scene.textures[size_t(m.normal_map.file)].color);
    EXPECT_TRUE(scene.textures[0].bytes->starts_with("\x89PNG"));
    EXPECT_EQ(scene.textures[0].path, "test.gltf#image0.png");
    EXPECT_EQ(scene.meshes[0].uv[1], (Vec2{1, 0}));
    // A primitive without one has the default material of the specification.
    const Triangle plain;
    const Material& d = read(plain.text(one_node)).materials.at(0);
    EXPECT_EQ(d.kind, Material::Kind::metallic_roughness);
    EXPECT_EQ(d.base_color, (Vec3{1, 1, 1}));
    EXPECT_EQ(d.metallic, 1);
    EXPECT_EQ(d.roughness, 1);
    EXPECT_FALSE(d.two_sided);
}

TEST(Gltf, TransmissionTextures) {
    Triangle t;
    t.floats({0, 0, 1, 0, 0, 1}, "VEC2");
    std::vector<std::string> ignored;
    const int view = t.bytes_view(encode_png(Image(2, 2, 3), {}, ignored));
    const auto read_with = [&](const std::string& extensions) {
        return read(t.glb(fmt::format(
            R"("nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_1":2}},"indices":1,"material":0}}]}}],)"
            R"("images":[{{"bufferView":{},"mimeType":"image/png"}}],"textures":[{{"source":0}}],"materials":[{{"name":"pane","extensions":{{{}}}}}])",
            view, extensions)));
    };
    const std::string pane =
        R"("KHR_materials_transmission":{"transmissionFactor":0.9,"transmissionTexture":{"index":0,"texCoord":1,"extensions":{"KHR_texture_transform":{"scale":[2,3]}}}})";
    Scene scene = read_with(pane);
    const Material& m = scene.materials[0];
    EXPECT_EQ(warnings.size(), 1u);  // no camera
    EXPECT_NEAR(m.transmission, 0.9, 1e-6);
    ASSERT_TRUE(m.transmission_map.used());
    EXPECT_FALSE(scene.textures[size_t(m.transmission_map.file)].color);
    EXPECT_EQ(m.transmission_map.scale, (Vec2{2, 3}));
    EXPECT_EQ(scene.meshes[0].uv[1], (Vec2{1, 0}));
    // A body of glass in places is not one that bends light, which is told.
    scene = read_with(pane + R"(,"KHR_materials_volume":{"thicknessFactor":1})");
    EXPECT_EQ(scene.materials[0].kind, Material::Kind::metallic_roughness);
    EXPECT_NE(std::find_if(warnings.begin(), warnings.end(),
                           [](const std::string& w) {
                               return w.find("taken as a thin sheet") != std::string::npos;
                           }),
              warnings.end());
    EXPECT_EQ(
        read_with(
            R"("KHR_materials_transmission":{"transmissionFactor":0.9},"KHR_materials_volume":{"thicknessFactor":1})")
            .materials[0]
            .kind,
        Material::Kind::dielectric);
}

TEST(Gltf, EachTextureReadsItsOwnTextureCoordinates) {
    Triangle t;
    std::vector<std::vector<Vec2>> uv;
    for (const float at : {0.0f, 10.0f, 20.0f}) {
        uv.push_back({{at, 0}, {at + 1, 0}, {at, 1}});
        EXPECT_EQ(t.floats({at, 0, at + 1, 0, at, 1}, "VEC2"), int(uv.size()) + 1);
    }
    std::vector<std::string> ignored;
    const int view = t.bytes_view(encode_png(Image(2, 2, 3), {}, ignored));
    const auto read_with = [&](const std::string& attributes, const std::string& material) {
        return read(t.glb(fmt::format(
            R"("nodes":[{{"mesh":0}}],"cameras":[],"meshes":[{{"name":"wall","primitives":[{{"attributes":{{"POSITION":0{}}},"indices":1,"material":0}}]}}],)"
            R"("images":[{{"bufferView":{},"mimeType":"image/png"}}],"textures":[{{"source":0}}],"materials":[{{"name":"brick",{}}}])",
            attributes, view, material)));
    };
    const std::string three = R"(,"TEXCOORD_0":2,"TEXCOORD_1":3,"TEXCOORD_2":4)";
    const std::string
        base = R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}})",
        normal = R"("normalTexture":{"index":0})",
        emissive =
            R"("emissiveTexture":{"index":0,"extensions":{"KHR_texture_transform":{"texCoord":2}}})";
    Scene scene = read_with(three, base + "," + normal);
    EXPECT_EQ(warnings.size(), 1u);  // no camera
    EXPECT_EQ(scene.meshes[0].uv, uv[1]);
    EXPECT_EQ(scene.meshes[0].uv2, uv[0]);
    EXPECT_EQ(scene.materials[0].base_color_map.uv_set, 0);
    EXPECT_EQ(scene.materials[0].normal_map.uv_set, 1);

    // A third set, told; and sets that the mesh has not.
    const auto told = [](const std::string& text) {
        return std::find(warnings.begin(), warnings.end(), "test.gltf: " + text) != warnings.end();
    };
    scene = read_with(three, base + "," + normal + "," + emissive);
    EXPECT_EQ(scene.materials[0].emission_map.uv_set, 0);
    EXPECT_TRUE(
        told("material 0 ('brick'): its textures read sets 1, 0 and 2 of texture "
             "coordinates; two can be read, what is on 2 takes 1"));
    scene = read_with(R"(,"TEXCOORD_0":2)", base + "," + normal);
    EXPECT_EQ(scene.meshes[0].uv, uv[0]);
    EXPECT_EQ(scene.meshes[0].uv2, uv[0]);
    EXPECT_TRUE(
        told("mesh 0 ('wall'), primitive 0: a texture of its material 0 ('brick') reads "
             "TEXCOORD_1, which it has not; TEXCOORD_0 is taken"));
    scene = read_with("", normal);
    EXPECT_TRUE(scene.meshes[0].uv.empty());
    EXPECT_TRUE(
        told("mesh 0 ('wall'), primitive 0: a texture of its material 0 ('brick') reads "
             "TEXCOORD_0, which it has not; it is one colour all over, the texture's at "
             "(0, 0)"));
    // Without textures there is nothing to read; coordinates are kept for another material.
    scene = read_with(three, R"("emissiveFactor":[1,0,0])");
    EXPECT_EQ(warnings.size(), 1u);
    EXPECT_EQ(scene.meshes[0].uv, uv[0]);
    EXPECT_NE(error_of([&] {
                  read_with(three, R"("normalTexture":{"index":0,"texCoord":-2})");
              }).find("material 0 ('brick'): a texture reads set -2"),
              std::string::npos);
}

TEST(Gltf, ExtensionsThatAreNotReadAreNamed) {
    const Triangle t;
    const std::string used =
        R"("extensionsUsed":["KHR_materials_ior","KHR_materials_sheen","KHR_materials_clearcoat","KHR_materials_sheen"],)";
    const std::string expected =
        "test.gltf: extensions that are not read: KHR_materials_clearcoat, KHR_materials_sheen; it "
        "is as it is without them";
    read(t.text(used + one_node));
    EXPECT_EQ(warnings.at(0), expected);
    read(t.text(R"("extensionsUsed":["KHR_materials_ior"],)" + one_node));
    EXPECT_EQ(warnings.size(), 1u);  // no camera
}

TEST(Gltf, CamerasAndLights) {
    const Triangle t;
    const std::string rest =
        R"("nodes":[{"mesh":0},{"camera":0,"translation":[0,0,5],"scale":[3,3,3]},{"camera":1,"name":"wide"},)"
        R"({"translation":[0,2,0],"extensions":{"KHR_lights_punctual":{"light":0}}}],)"
        R"("cameras":[{"name":"near","type":"perspective","perspective":{"yfov":0.5,"znear":0.1}},{"name":"wide","type":"perspective","perspective":{"yfov":1.5,"znear":0.1}}],)"
        R"("extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","color":[1,0.5,0.25],"intensity":8,"spot":{"innerConeAngle":0.1,"outerConeAngle":0.4}}]}},)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])";
    const Scene scene = read(t.text(rest));
    EXPECT_TRUE(warnings.empty());
    EXPECT_EQ(scene.camera.name, "near");
    EXPECT_EQ(scene.camera.to_world[0].origin, (Vec3{0, 0, 5}));
    EXPECT_EQ(scene.camera.vertical_fov, 0.5f);
    EXPECT_EQ(read(t.text(rest), {.camera = "wide", .animation = ""}).camera.vertical_fov, 1.5f);
    EXPECT_EQ(read(t.text(rest), {.camera = "1", .animation = ""}).camera.vertical_fov, 1.5f);
    EXPECT_EQ(error_of([&] { read(t.text(rest), {.camera = "wode", .animation = ""}); }),
              "test.gltf: camera 'wode': the file has no such camera; did you mean 'wide'?");
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_EQ(scene.lights[0].shape, Light::Shape::spot);
    EXPECT_EQ(scene.lights[0].radiance, (Vec3{8, 4, 2}));
    EXPECT_EQ(scene.lights[0].outer_cone, 0.4f);
}

// One node turns half round about y in a second and goes 4 to the right.
std::string moving_node(GltfMaker& t) {
    const int times = t.floats({0, 0.5f, 1}, "SCALAR");
    const int turns = t.floats({0, 0, 0, 1, 0, 0.70710678f, 0, 0.70710678f, 0, 1, 0, 0}, "VEC4");
    const int places = t.floats({0, 0, 0, 2, 0, 0, 4, 0, 0}, "VEC3");
    return fmt::format(
        R"("animations":[{{"name":"go","samplers":[{{"input":{0},"output":{1}}},{{"input":{0},"output":{2}}}],)"
        R"("channels":[{{"sampler":0,"target":{{"node":0,"path":"rotation"}}}},{{"sampler":1,"target":{{"node":0,"path":"translation"}}}}]}}],{3})",
        times, turns, places, one_node);
}

TEST(Gltf, AnimationBecomesMotionKeysOverTheShutter) {
    Triangle t;
    const std::string rest = moving_node(t);  // adds accessors: before the text is made
    const std::string bytes = t.text(rest);
    const Scene scene = read(bytes, {"", "", 0.25f, 0.75f});
    const auto& keys = scene.instances[0].to_world;
    ASSERT_GE(keys.size(), 2u);
    EXPECT_LE(keys.size(), 3u);
    EXPECT_NEAR(keys.front().origin.x, 1, 1e-4);
    EXPECT_NEAR(keys.back().origin.x, 3, 1e-4);
    const Affine middle = render::KeyedMotion(keys).at(0.5f);
    EXPECT_NEAR(middle.x.z, -1, 1e-3);  // a quarter turn
    EXPECT_NEAR(middle.origin.x, 2, 1e-4);
    // A shutter of no length, and one after the end: still.
    EXPECT_EQ(read(bytes, {"", "", 0.5f, 0.5f}).instances[0].to_world.size(), 1u);
    EXPECT_EQ(read(bytes, {"", "", 5, 6}).instances[0].to_world.size(), 1u);
    EXPECT_NE(error_of([&] {
                  read(bytes, {"", "gone", 0, 1});
              }).find("it has no such animation"),
              std::string::npos);
}

// Where things are when the shutter opens and when it closes: not near it, there.
TEST(Gltf, BothEndsOfTheShutterAreExact) {
    // At time t: node 0 is t to the right, the joint t up, the weight t.
    Triangle t;
    const int times = t.floats({0, 1}, "SCALAR"), right = t.floats({0, 0, 0, 1, 0, 0}, "VEC3");
    const int up = t.floats({0, 0, 0, 0, 1, 0}, "VEC3"), weight = t.floats({0, 1}, "SCALAR");
    const int target = t.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    const int joints = t.shorts({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4", 4);
    const int shares = t.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
    const auto bytes = [&](const std::string& interpolation) {
        return t.text(fmt::format(
            R"("nodes":[{{"mesh":0}},{{"mesh":1}},{{"mesh":2,"skin":0}},{{}}],"skins":[{{"joints":[3]}}],"meshes":[)"
            R"({{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}},)"
            R"({{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"targets":[{{"POSITION":{0}}}]}}]}},)"
            R"({{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":{1},"WEIGHTS_0":{2}}},"indices":1}}]}}],)"
            R"("animations":[{{"samplers":[{{"input":{3},"output":{4},"interpolation":"{7}"}},{{"input":{3},"output":{5},"interpolation":"{7}"}},{{"input":{3},"output":{6},"interpolation":"{7}"}}],)"
            R"("channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}},{{"sampler":1,"target":{{"node":1,"path":"weights"}}}},{{"sampler":2,"target":{{"node":3,"path":"translation"}}}}]}}])",
            target, joints, shares, times, right, weight, up, interpolation));
    };
    // Ends that a step of a sixteenth does not meet by itself.
    for (const auto& [open, close] : {std::pair{0.1f, 0.7f}, std::pair{0.3f, 0.9f},
                                      std::pair{1.0f / 3, 1.0f / 3 + 1.0f / 48}}) {
        const Scene scene = read(bytes("LINEAR"), {"", "", open, close});
        const auto& keys = scene.instances[0].to_world;
        ASSERT_EQ(keys.size(), 2u);
        EXPECT_EQ(keys.front().origin, (Vec3{open, 0, 0}));
        EXPECT_EQ(keys.back().origin, (Vec3{close, 0, 0}));
        ASSERT_EQ(scene.meshes[1].steps, 2);
        EXPECT_EQ(scene.meshes[1].positions[0], (Vec3{0, 0, open}));
        EXPECT_EQ(scene.meshes[1].positions[3], (Vec3{0, 0, close}));
        ASSERT_EQ(scene.meshes[2].steps, 2);
        EXPECT_EQ(scene.meshes[2].positions[0], (Vec3{0, open, 0}));
        EXPECT_EQ(scene.meshes[2].positions[3], (Vec3{0, close, 0}));
        EXPECT_EQ(scene.camera.shutter_open, open);
        EXPECT_EQ(scene.camera.shutter_close, close);
    }
    // A jump at the very end is seen there, one just after is not; before and after the animation
    // its first and last key hold.
    Scene scene = read(bytes("STEP"), {"", "", 0.3f, 1});
    EXPECT_EQ(scene.instances[0].to_world.back().origin.x, 1);
    EXPECT_EQ(scene.meshes[1].positions[3].z, 1);
    scene = read(bytes("STEP"), {"", "", 0.3f, std::nextafter(1.0f, 0.0f)});
    EXPECT_EQ(scene.instances[0].to_world.size(), 1u);
    EXPECT_EQ(scene.meshes[1].steps, 1);
    scene = read(bytes("LINEAR"), {"", "", -1, 2});
    EXPECT_EQ(scene.meshes[2].positions[0].y, 0);
    EXPECT_EQ(scene.meshes[2].positions[3].y, 1);
    EXPECT_EQ(scene.instances[0].to_world.front().origin.x, 0);
    EXPECT_EQ(scene.instances[0].to_world.back().origin.x, 1);
}

TEST(Gltf, MorphTargetsAndSkinsMoveVertices) {
    Triangle t;
    const int target = t.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    const int times = t.floats({0, 1}, "SCALAR"), weights = t.floats({0, 1}, "SCALAR");
    Scene scene = read(
        t.text(fmt::format(
            R"("nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"targets":[{{"POSITION":{}}}]}}]}}],)"
            R"("animations":[{{"samplers":[{{"input":{},"output":{}}}],"channels":[{{"sampler":0,"target":{{"node":0,"path":"weights"}}}}]}}])",
            target, times, weights)),
        {"", "", 0, 0.5f});
    ASSERT_EQ(scene.meshes[0].steps, 2);
    EXPECT_NEAR(scene.meshes[0].positions[0].z, 0, 1e-6);
    EXPECT_NEAR(scene.meshes[0].positions[3].z, 0.5, 1e-6);

    Triangle s;
    const int joints = s.shorts({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, "VEC4", 4);
    const int shares = s.floats({1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0, 1, 0, 0}, "VEC4");
    const int when = s.floats({0, 1}, "SCALAR"), where = s.floats({0, 0, 0, 0, 8, 0}, "VEC3");
    scene = read(
        s.text(fmt::format(
            R"("nodes":[{{"mesh":0,"skin":0,"translation":[9,9,9]}},{{}},{{}}],"skins":[{{"joints":[1,2]}}],)"
            R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":{},"WEIGHTS_0":{}}},"indices":1}}]}}],)"
            R"("animations":[{{"samplers":[{{"input":{},"output":{}}}],"channels":[{{"sampler":0,"target":{{"node":2,"path":"translation"}}}}]}}])",
            joints, shares, when, where)),
        {"", "", 0, 0.25f});
    const Mesh& mesh = scene.meshes[0];
    ASSERT_EQ(mesh.steps, 2);
    EXPECT_EQ(scene.instances[0].to_world[0].origin,
              (Vec3{}));  // a skin stands by its joints alone
    EXPECT_NEAR(mesh.positions[3].y, 0, 1e-6);
    EXPECT_NEAR(mesh.positions[4].y, 1, 1e-6);  // half of 2
    EXPECT_NEAR(mesh.positions[5].y, 3, 1e-6);  // 1 + all of 2
}

TEST(Gltf, BrokenFilesAreTold) {
    Triangle t;
    const auto says = [&](const std::string& rest, const std::string& expected) {
        const std::string found = error_of([&] { read(t.text(rest)); });
        EXPECT_NE(found.find(expected), std::string::npos) << found << "\nexpected: " << expected;
    };
    const auto mesh = [](const std::string& primitive) {
        return R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[)" + primitive + "]}]";
    };
    says(mesh(R"({"attributes":{"POSITION":7},"indices":1})"), "primitive 0: accessor 7 of 2");
    says(mesh(R"({"attributes":{"POSITION":1},"indices":1})"),
         "accessor 1: 1 numbers an element; expected 3");
    says(mesh(R"({"attributes":{"POSITION":0},"indices":0})"), "accessor 0: not a list of indices");
    says(mesh(R"({"attributes":{"POSITION":0},"indices":1,"material":3})"), "material 3 of 0");
    says(R"("nodes":[{"mesh":4}])", "node 0: mesh 4 of 0");
    says(R"("nodes":[{"children":[0]}],"scenes":[{"nodes":[0]}])", "node 0: it is its own child");
    says(
        R"("nodes":[{"children":[1]},{"children":[0],"mesh":0}],"scenes":[{"nodes":[0]}],"meshes":[])",
        "node 0: it is its own ancestor");
    says(R"("nodes":[{"children":[2]},{"children":[2]},{}])",
         "node 2: it is a child of nodes 0 and 1");
    says(R"("nodes":[{"rotation":[0,0,0,0]}])", "node 0: its rotation is zero");
    says(R"("extensionsRequired":["KHR_draco_mesh_compression"])",
         "requires the extension 'KHR_draco_mesh_compression', which is not read; export it again "
         "without "
         "compression");
    says(R"("extensionsRequired":["MY_cloth"])",
         "'MY_cloth', which is not read; export it again without it");
    const std::string pictured =
        R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],)"
        R"("materials":[{"normalTexture":{"index":0}}],"textures":[{"source":0}],"images":[{"bufferView":)";

    GltfMaker cut;  // the buffer ends before the picture's view of it does
    cut.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
    cut.shorts({0, 1, 2});
    cut.bytes_view("\x89PNG with something after it");
    std::string text = cut.text(pictured + R"(2,"mimeType":"image/png"}])");
    const std::string whole = R"("byteOffset":44)";
    text.replace(text.find(whole), whole.size(), R"("byteOffset":54)");
    EXPECT_NE(error_of([&] {
                  read(text);
              }).find("material 0, image 0: buffer view 2 reaches past the end of buffer 0"),
              std::string::npos)
        << error_of([&] { read(text); });
    const std::string long_name(300, 'x');  // no file can have it
    says(pictured.substr(0, pictured.rfind("\"bufferView\"")) + R"("uri":")" + long_name + "\"}]",
         "material 0, image 0: no file 'xxx");
    EXPECT_NE(error_of([&] {
                  read(R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":1,"uri":")" +
                       long_name + "\"}]}");
              }).find("buffer 0: no file 'xxx"),
              std::string::npos);
    says("", "nothing to see");
    EXPECT_NE(error_of([&] {
                  read("{\"asset\":{\"version\":\"1.0\"}}");
              }).find("glTF 1.0; only 2.0 is read"),
              std::string::npos);
    EXPECT_NE(error_of([&] { read("{\"asset\":"); }).find("test.gltf:1:"), std::string::npos);
    const std::string glb = t.glb(one_node);
    for (size_t size = 0; size < glb.size(); ++size)
        EXPECT_NE(error_of([&] { read(glb.substr(0, size)); }), "") << size;

    GltfMaker nan;
    nan.floats({0, 0, 0, 1, 0, 0, 0, NAN, 0}, "VEC3");
    nan.shorts({0, 1, 2});
    EXPECT_NE(error_of([&] { read(nan.text(one_node)); }).find("accessor 0: element 2 is nan"),
              std::string::npos);
    GltfMaker past;
    past.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
    past.shorts({0, 1, 3});
    EXPECT_NE(
        error_of([&] { read(past.text(one_node)); }).find("index 2 is 3, there are 3 vertices"),
        std::string::npos);
}

// Khronos's and assimp's test files, where Debian's package assimp-testmodels is unpacked.
TEST(Gltf, ForeignTestFilesNeverCrash) {
    const char* set = std::getenv("WEFT_ASSIMP_MODELS");
    const std::filesystem::path folder = set ? set : "/usr/share/assimp/models";
    if (!std::filesystem::is_directory(folder))
        GTEST_SKIP() << "no " << folder << ": install assimp-testmodels, or set WEFT_ASSIMP_MODELS";
    size_t read_well = 0, refused = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".gltf" && extension != ".glb" && extension != ".obj") continue;
        std::vector<std::string> told;
        try {
            read_scene_file(entry.path().string(), {}, told);
            ++read_well;
        } catch (const Error& e) {
            EXPECT_NE(std::string(e.what()).find(entry.path().filename().string()),
                      std::string::npos)
                << e.what();
            ++refused;
        }
    }
    EXPECT_GT(read_well, 20u);
    EXPECT_GT(refused, 5u);
}

}  // namespace
}  // namespace weft
