// A material's maps on a surface: each reads its own set of texture coordinates.
#include <array>

#include "image/png_file.h"
#include "render/render_test.h"

namespace weft::render {
namespace {

// Two texels side by side: a surface with coordinates (0.25, 0.5) has the left one all over, with
// (0.75, 0.5) the right one.
TextureFile two_texels(std::array<float, 4> left, std::array<float, 4> right) {
    Image image(2, 1, 4);
    std::copy(left.begin(), left.end(), image.at(0, 0));
    std::copy(right.begin(), right.end(), image.at(1, 0));
    std::vector<std::string> warnings;
    TextureFile file;
    file.path = "two.png";
    file.bytes = std::make_shared<const std::string>(encode_png(image, {}, warnings));
    file.color = false;
    return file;
}

// A floor seen from above, under an even sky, whose first set of coordinates lies on the left texel
// and whose second on the right.
Scene textured_floor(TextureFile file) {
    Scene scene;
    scene.textures.push_back(std::move(file));
    scene.materials.push_back(diffuse(1));
    scene.meshes.push_back(floor_mesh(10));
    Mesh& mesh = scene.meshes[0];
    // A little of each texel, so that the surface runs along both axes.
    for (Vec2& uv : mesh.uv) {
        mesh.uv2.push_back({0.7495f + 0.001f * uv.x, 0.5f + 0.001f * uv.y});
        uv = {0.2495f + 0.001f * uv.x, 0.5f + 0.001f * uv.y};
    }
    scene.instances.push_back(placed(0));
    scene.environment.radiance = {1, 1, 1};
    scene.camera = camera_at({0, 3, 0}, {0, 0, 0}, 20, {0, 0, -1});
    return scene;
}

// Mean of a channel over the picture, with `map` on the floor's set 0 or 1.
double channel_mean(Scene scene, TextureMap Material::*map, int set, const std::string& channel,
                    size_t component = 0) {
    TextureMap& used = scene.materials[0].*map;
    used.file = 0, used.uv_set = set;
    RenderOptions o;
    o.width = o.height = 8;
    const Samples s = render_scene(scene, o, 16, {"basic", "albedo", "emission", "normal"});
    const auto all = s.values(channel);
    const size_t each = all.size() / s.size();
    double sum = 0;
    for (size_t i = component; i < all.size(); i += each) sum += double(all[i]);
    return sum / double(s.size());
}

TEST(Maps, each_reads_its_own_texture_coordinates) {
    const Scene scene = textured_floor(two_texels({0.2f, 0.2f, 0.2f, 1}, {0.8f, 0.6f, 0.4f, 1}));
    EXPECT_NEAR(channel_mean(scene, &Material::base_color_map, 0, "albedo"), 0.2, 2e-3);
    EXPECT_NEAR(channel_mean(scene, &Material::base_color_map, 1, "albedo"), 0.8, 2e-3);
    Scene lamp = scene;
    lamp.materials[0].emission = {2, 2, 2};
    EXPECT_NEAR(channel_mean(lamp, &Material::emission_map, 0, "emission"), 0.4, 4e-3);
    EXPECT_NEAR(channel_mean(lamp, &Material::emission_map, 1, "emission", 1), 1.2, 4e-3);
    // A mask that lets through what is left of it.
    Scene fence = scene;
    fence.materials[0].alpha = Material::Alpha::mask;
    EXPECT_EQ(channel_mean(fence, &Material::alpha_map, 0, "alpha"), 1);  // its alpha is 1
    fence = textured_floor(two_texels({1, 1, 1, 0.2f}, {1, 1, 1, 0.8f}));
    fence.materials[0].alpha = Material::Alpha::mask;
    EXPECT_EQ(channel_mean(fence, &Material::alpha_map, 0, "alpha"), 0);
    EXPECT_EQ(channel_mean(fence, &Material::alpha_map, 1, "alpha"), 1);
}

// A sheet between the camera and a lamp below it is as bright as it lets light through.
TEST(Maps, transmission_is_where_its_map_says) {
    Scene scene = textured_floor(two_texels({0, 0, 0, 1}, {0.8f, 0.8f, 0.8f, 1}));
    scene.environment = {};
    scene.materials[0] = Material{};
    scene.materials[0].base_color = {1, 1, 1};
    scene.materials[0].roughness = 0.5f;
    Light lamp;
    lamp.to_world = {look_at({0, -5, 0}, {0, 0, 0}, {0, 0, 1}) * scale({20, 20, 1})};
    scene.lights.push_back(lamp);
    const auto seen = [&](float transmission, bool mapped, int set) {
        Scene s = scene;
        s.materials[0].transmission = transmission;
        if (!mapped) s.textures.clear();
        RenderOptions o;
        o.width = o.height = 8;
        if (mapped)
            s.materials[0].transmission_map.file = 0, s.materials[0].transmission_map.uv_set = set;
        return estimate(render_scene(s, o, 256, {"basic"}).rgb(), 3);
    };
    EXPECT_LT(seen(1, true, 0).mean, 1e-6);  // none there
    const Estimate map = seen(1, true, 1), number = seen(0.8f, false, 0);
    EXPECT_GT(number.mean, 0.5);
    EXPECT_NEAR(map.mean, number.mean, 0.005 * number.mean + 3 * (map.error + number.error));
    const Estimate half = seen(0.5f, true, 1), less = seen(0.4f, false, 0);
    EXPECT_NEAR(half.mean, less.mean, 0.005 * less.mean + 3 * (half.error + less.error));
}

// Lights are drawn on an emitting mesh as bright as it is seen: a plate above the floor tells.
TEST(Maps, an_emitter_lights_by_its_own_texture_coordinates) {
    Scene scene = textured_floor(two_texels({0.25f, 0.25f, 0.25f, 1}, {0.75f, 0.75f, 0.75f, 1}));
    scene.environment = {};
    scene.materials[0].base_color = {};
    scene.materials[0].emission = {1, 1, 1};
    scene.materials[0].emission_map.file = 0;
    scene.materials.push_back(diffuse(1));
    scene.meshes.push_back(floor_mesh(0.5f, 1));
    scene.instances.push_back(placed(1, {translate({0, 10, 0}) * rotate({1, 0, 0}, pi)}, 2));
    scene.camera = camera_at({1, 8, 0}, {0, 10, 0}, 5, {0, 0, 1});
    RenderOptions o;
    o.width = o.height = 4;
    o.max_depth = 1;
    // From a square of half width a at distance a: 4 / pi * atan(1 / sqrt 2) / sqrt 2.
    const double seen = 4 / pi * std::atan(std::sqrt(0.5)) * std::sqrt(0.5);
    for (const int set : {0, 1}) {
        scene.materials[0].emission_map.uv_set = set;
        const Estimate got = estimate(render_scene(scene, o, 1024, {"basic"}).rgb(), 3);
        const double expected = seen * (set == 0 ? 0.25 : 0.75);
        EXPECT_NEAR(got.mean, expected, 0.01 * expected + 4 * got.error) << set;
    }
}

TEST(Maps, bumps_follow_the_picture_however_it_is_placed) {
    // A normal that leans to the picture's right, by 3 to 4.
    const auto leaning = [](double along_x, double along_z, int set, TextureMap how) {
        Scene scene = textured_floor(two_texels({0.5f, 0.5f, 1, 1}, {0.8f, 0.5f, 0.9f, 1}));
        scene.materials[0].normal_map = how;
        EXPECT_NEAR(channel_mean(scene, &Material::normal_map, set, "normal", 0), along_x, 0.01);
        EXPECT_NEAR(channel_mean(scene, &Material::normal_map, set, "normal", 2), along_z, 0.01);
    };
    leaning(0, 0, 0, {});  // the left texel is flat
    leaning(0.6, 0, 1, {});
    TextureMap turned;  // the picture turned clockwise, as seen with v down: its right is along +v
    turned.rotation = pi / 2;
    turned.offset = {0.25f, 1};
    leaning(0, 0.6, 0, turned);
    TextureMap mirrored;
    mirrored.scale = {-1, 1};
    leaning(-0.6, 0, 0, mirrored);
}

}  // namespace
}  // namespace weft::render
