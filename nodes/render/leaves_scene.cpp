// leaves: an autumn wood, its leaves in the air and on the ground, and butterflies, from an arm's
// length to forty metres. Everything in the air falls, tumbles or flaps while the shutter is open.
#include <algorithm>
#include <array>
#include <cmath>

#include "render/foliage.h"
#include "render/procedural_scene.h"
#include "render/shapes.h"

namespace weft {
namespace {

enum Kind { air, ground, trunk, butterfly };
constexpr float eye = 1.5f, tan_half = 0.40f, wide = 1.9f;  // of the view: half height, width

struct Leaves {
    SceneBuilder build;
    std::uint64_t seed;
    std::array<int, 3> shapes{};
    std::array<int, 6> colors{};

    void materials() {
        const int veins = leaf_texture(build);
        const std::array<Vec3, 6> tints = {Vec3{0.80f, 0.16f, 0.03f}, Vec3{0.95f, 0.42f, 0.04f},
                                           Vec3{0.95f, 0.72f, 0.10f}, Vec3{0.42f, 0.55f, 0.08f},
                                           Vec3{0.45f, 0.09f, 0.05f}, Vec3{0.60f, 0.34f, 0.12f}};
        for (size_t i = 0; i < tints.size(); ++i) {
            Material m = glossy("leaf " + std::to_string(i), tints[i], 0.45f);
            m.base_color_map.file = veins;
            colors[i] = build.material(m);
        }
        shapes = {build.mesh(leaf_mesh(0.42f, 0.25f, 0.12f), colors[0], "leaf"),
                  build.mesh(leaf_mesh(0.60f, 0.15f, -0.15f), colors[1], "broad leaf"),
                  build.mesh(leaf_mesh(0.26f, 0.35f, 0.05f), colors[2], "narrow leaf")};
    }

    Affine turned(const Dice& dice, int place) const {
        return rotate(dice.direction(place), dice(place + 2, 0, 2 * pi));
    }

    void falling(size_t count) {
        for (size_t i = 0; i < count; ++i) {
            const Dice dice(seed, air, i);
            // Equally many at every power of the distance: small far ones, a few large near ones.
            const float z = 1.4f * std::pow(22.0f, std::sqrt(dice(0)));
            const float y = eye + z * tan_half * dice(1, -1.0f, 1.1f);
            if (y < 0.05f) continue;
            Affine at = turned(dice, 2) * scale(dice(6, 0.07f, 0.16f));
            at.origin = {z * tan_half * wide * dice(7, -1.05f, 1.05f), y, -z};
            const Vec3 wind = dice(10, {0.0f, -0.07f, -0.02f}, {0.06f, -0.02f, 0.02f});
            const int shape = shapes[dice.below(13, 3)];
            build.place(shape, moving(at, wind, dice.direction(14), dice(16, -0.5f, 0.5f)),
                        colors[dice.below(17, 6)]);
        }
    }

    void fallen(size_t count) {
        for (size_t i = 0; i < count; ++i) {
            const Dice dice(seed, ground, i);
            const float z = 2.2f * std::pow(16.0f, dice(0));
            Affine at = rotate({0, 1, 0}, dice(1, 0, 2 * pi)) *
                        rotate({1, 0, 0}, dice(2, -0.35f, 0.35f)) *
                        rotate({0, 0, 1}, dice(3, -0.1f, 0.5f)) * scale(dice(4, 0.09f, 0.18f));
            at.origin = {z * tan_half * wide * dice(5, -1.2f, 1.2f), 0.02f, -z};
            build.place(shapes[dice.below(6, 3)], at, colors[dice.below(7, 6)]);
        }
    }

    void wood(size_t count) {
        Material bark = diffuse("bark", {1, 1, 1});
        bark.base_color_map.file = bark_texture(build, seed);
        bark.base_color_map.scale = {1, 3};
        const int material = build.material(bark);
        for (size_t i = 0; i < count; ++i) {
            const Dice dice(seed, trunk, i);
            const float z = 5 + 42 * (float(i) + dice(0)) / float(count);
            // None in the middle of the path until it is far away.
            const float side = dice(1) < 0.5f ? -1.0f : 1.0f;
            const float x = side * (0.22f + dice(2, 0, 0.9f)) * z * tan_half * wide;
            std::vector<Vec3> points;
            std::vector<float> radii;
            const float radius = dice(3, 0.12f, 0.30f);
            for (int k = 0; k <= 10; ++k) {
                const float h = 1.1f * float(k);
                points.push_back({x + 0.10f * (noise(h, float(i), seed) - 0.5f) * h, h - 0.05f,
                                  -z + 0.08f * (noise(h, float(i), seed + 1) - 0.5f) * h});
                radii.push_back(radius * (1 - 0.06f * float(k)) * (k == 0 ? 1.5f : 1.0f));
            }
            build.place(build.mesh(tube_mesh(points, radii, 20), material, "trunk"), Affine{});
        }
    }

    void butterflies(size_t count) {
        const std::array<int, 3> wings = {
            wing_texture(build, "monarch", {0.90f, 0.28f, 0.02f}, {0.9f, 0.9f, 0.85f}),
            wing_texture(build, "morpho", {0.04f, 0.22f, 0.85f}, {0.7f, 0.85f, 0.95f}),
            wing_texture(build, "brimstone", {0.90f, 0.80f, 0.15f}, {0.9f, 0.5f, 0.2f})};
        std::array<int, 3> painted{};
        for (size_t i = 0; i < 3; ++i) {
            Material m = glossy("wing " + std::to_string(i), {1, 1, 1}, 0.5f);
            m.base_color_map.file = wings[i];
            painted[i] = build.material(m);
        }
        Mesh mirrored;
        append(mirrored, wing_mesh(), scale(Vec3{-1, 1, 1}));
        const int right = build.mesh(wing_mesh(), painted[0], "wing");
        const int left = build.mesh(mirrored, painted[0], "left wing");
        const std::array<Vec2, 5> profile = {Vec2{0, -0.5f}, Vec2{0.05f, -0.3f}, Vec2{0.035f, 0.1f},
                                             Vec2{0.06f, 0.35f}, Vec2{0, 0.5f}};
        const int body = build.mesh(lathe_mesh(smooth_profile(profile, 4), 12),
                                    build.material(diffuse("body", {0.04f, 0.03f, 0.03f})), "body");
        for (size_t i = 0; i < count; ++i) {
            const Dice dice(seed, butterfly, i);
            const float z = 1.6f * std::pow(7.0f, dice(0));
            const float size = dice(1, 0.09f, 0.15f);
            const Vec3 at{z * tan_half * wide * dice(2, -0.85f, 0.85f),
                          std::max(0.3f, eye + z * tan_half * dice(3, -0.6f, 0.9f)), -z};
            const Affine fly = rotate({0, 1, 0}, dice(4, 0, 2 * pi)) *
                               rotate({1, 0, 0}, dice(5, 0.4f, 1.2f)) * scale(size);
            const Vec3 velocity = fly.vector({0, 0, -1}) * dice(6, 0.05f, 0.25f);
            const float lift = dice(7, -0.3f, 0.9f), beat = dice(8, -0.6f, 0.6f);
            for (const float side : {1.0f, -1.0f}) {
                std::vector<Affine> keys;
                for (int k = 0; k < 3; ++k) {
                    const float t = 0.5f * float(k);
                    Affine key = fly * rotate({0, 0, 1}, side * (lift + beat * (t - 0.5f)));
                    key.origin = at + velocity * t;
                    keys.push_back(key);
                }
                build.place(side > 0 ? right : left, keys, painted[i % 3]);
            }
            Affine along = fly * rotate({1, 0, 0}, -pi / 2) * scale(Vec3{0.9f, 1, 0.9f});
            along.origin = at;
            build.place(body, moving(along, velocity));
        }
    }

    void surroundings() {
        const std::uint64_t s = seed;
        Material soil = diffuse("ground", {1, 1, 1});
        soil.base_color_map.file = build.texture("ground", 512, 512, [s](float u, float v) {
            const float grass = noise(u * 8, v * 8, s + 11, 3, 8);
            const float fine = noise(u * 64, v * 64, s + 12, 3, 64);
            return lerp(Vec3{0.10f, 0.07f, 0.04f}, Vec3{0.10f, 0.16f, 0.03f}, grass) *
                   (0.5f + fine);
        });
        soil.base_color_map.scale = {20, 20};
        build.place(build.mesh(plane_mesh(), build.material(soil), "ground"), scale(60));

        const Vec3 sun = unit(Vec3{-0.72f, 0.5f, 0.30f});
        build.sky([sun](Vec3 d) {
            const float glow = std::max(0.0f, dot(d, sun)), h = std::max(d.y, 0.0f);
            const Vec3 haze{1.05f, 0.90f, 0.66f}, blue{0.28f, 0.44f, 0.75f};
            const Vec3 air_light = lerp(haze, blue, std::min(1.0f, 1.6f * std::sqrt(h)));
            const Vec3 warm = Vec3{2.2f, 1.5f, 0.8f} * std::pow(glow, 24.0f);
            return d.y < -0.02f ? Vec3{0.16f, 0.12f, 0.08f} : air_light * 0.8f + warm;
        });
        Light light;
        light.name = "sun", light.shape = Light::Shape::directional;
        light.radiance = Vec3{5.5f, 4.6f, 3.2f};
        light.to_world = {look_at(sun, {0, 0, 0})};
        build.scene.lights.push_back(light);

        SceneCamera& camera = build.scene.camera;
        camera.name = "camera";
        camera.to_world = {look_at({0, eye, 0}, {0, eye, -1})};
        camera.vertical_fov = 2 * std::atan(tan_half);
        camera.focus = 3.2f, camera.lens_radius = 0.03f;
    }
};

}  // namespace

Scene leaves_scene(std::uint64_t seed, float size) {
    Leaves leaves;
    leaves.seed = seed;
    leaves.surroundings();
    leaves.materials();
    leaves.wood(size_t(std::clamp(60 * std::sqrt(size), 4.0f, 300.0f)));
    leaves.fallen(size_t(2500 * size));
    leaves.falling(size_t(3200 * size));
    leaves.butterflies(size_t(std::max(3.0f, 28 * std::sqrt(size))));
    return std::move(leaves.build.scene);
}

}  // namespace weft
