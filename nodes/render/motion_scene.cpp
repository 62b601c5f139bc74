// motion: wheels that roll by, fans that turn, balls and dice that fly, in front of a painted wall
// and over a patterned floor, all of them still. Streaks of every length and direction, straight
// and curved.
#include <algorithm>
#include <array>
#include <cmath>

#include "render/procedural_scene.h"
#include "render/scene_builder.h"
#include "render/shapes.h"

namespace weft {
namespace {

constexpr float floor_tiles = 6;

Vec3 hue(float h) {
    const auto wave = [h](float shift) { return 0.5f + 0.5f * std::cos(2 * pi * (h + shift)); };
    return {0.08f + 0.80f * wave(0), 0.06f + 0.72f * wave(0.33f), 0.05f + 0.80f * wave(0.67f)};
}

Vec3 mural(float u, float v, std::uint64_t seed) {
    // Rows of bricks, each a colour of its own, with a frieze of triangles between.
    const float rows = 14, y = v * rows, row = std::floor(y);
    const float x = u * 20 + (int(row) % 2 ? 0.5f : 0.0f), column = std::floor(x);
    const float fx = x - column, fy = y - row;
    const float pick = noise(column + 0.5f, row + 0.5f, seed + 21, 1);
    const float grain = 0.8f + 0.4f * noise(u * 120, v * 60, seed + 22, 3);
    if (int(row) % 5 == 2) {
        const bool inside = fy > std::fabs(2 * fx - 1);
        return (inside ? Vec3{0.80f, 0.62f, 0.18f} : Vec3{0.06f, 0.10f, 0.22f}) * grain;
    }
    if (fx < 0.05f || fy < 0.08f) return Vec3{0.50f, 0.47f, 0.42f} * grain;
    return lerp(Vec3{0.30f, 0.10f, 0.06f}, Vec3{0.55f, 0.32f, 0.20f}, pick) * grain;
}

// A wheel about +z: tyre, hub and spokes.
Mesh wheel_mesh(int spokes) {
    Mesh mesh;
    const Affine upright = rotate({1, 0, 0}, pi / 2);
    append(mesh, torus_mesh(0.09f, 72), upright);
    const std::array<Vec2, 6> hub = {Vec2{0, -0.12f},    Vec2{0.08f, -0.12f}, Vec2{0.12f, -0.08f},
                                     Vec2{0.12f, 0.08f}, Vec2{0.08f, 0.12f},  Vec2{0, 0.12f}};
    append(mesh, lathe_mesh(hub, 32, 0.3f), upright);
    for (int i = 0; i < spokes; ++i)
        append(mesh, cube_mesh(),
               rotate({0, 0, 1}, 2 * pi * float(i) / float(spokes)) * translate({0, 0.52f, 0}) *
                   scale(Vec3{0.025f, 0.42f, 0.02f}));
    return mesh;
}

// Blades about +z, each twisted like a propeller's.
Mesh fan_mesh(int blades) {
    Mesh mesh;
    for (int i = 0; i < blades; ++i)
        append(mesh, wall_mesh(4),
               rotate({0, 0, 1}, 2 * pi * float(i) / float(blades)) * translate({0, 0.58f, 0}) *
                   rotate({0, 1, 0}, 0.5f) * scale(Vec3{0.16f, 0.42f, 1}));
    append(mesh, sphere_mesh(32), scale(Vec3{0.18f, 0.18f, 0.14f}));
    return mesh;
}

struct Motion {
    SceneBuilder build;
    std::uint64_t seed = 1;

    int painted(const std::string& name, float roughness,
                const std::function<Vec3(float, float)>& color, int width, int height) {
        Material m = glossy(name, {1, 1, 1}, roughness);
        m.base_color_map.file = build.texture(name, width, height, color);
        return build.material(m);
    }

    void surroundings() {
        const std::uint64_t s = seed;
        build.place(build.mesh(wall_mesh(),
                               painted(
                                   "mural", 0.8f, [s](float u, float v) { return mural(u, v, s); },
                                   1280, 640),
                               "wall"),
                    translate({0, 2.2f, -3}) * scale(Vec3{6, 3, 1}));
        const int tiles = painted(
            "tiles", 0.25f,
            [s](float u, float v) {
                const float x = u * 2, y = v * 2;
                const bool dark = (int(x) + int(y)) % 2 == 1;
                const float fx = std::fabs(x - std::round(x)), fy = std::fabs(y - std::round(y));
                const float grain = 0.75f + 0.5f * noise(u * 16, v * 16, s + 31, 4, 16);
                if (std::min(fx, fy) < 0.015f) return Vec3{0.12f, 0.12f, 0.12f};
                return (dark ? Vec3{0.10f, 0.14f, 0.17f} : Vec3{0.55f, 0.53f, 0.48f}) * grain;
            },
            512, 512);
        build.scene.materials[size_t(tiles)].base_color_map.scale = {floor_tiles, floor_tiles};
        build.place(build.mesh(plane_mesh(), tiles, "floor"), translate({0, -0.8f, 0}) * scale(6));

        build.quad_light("lamp", {-2.6f, 4.6f, 3.2f}, {0, 0.6f, -1}, 1.0f, 0.8f, {42, 40, 36});
        build.quad_light("warm lamp", {3.8f, 2.6f, 1.5f}, {0, 0.4f, -1}, 0.35f, 0.35f,
                         {80, 48, 22});
        build.scene.environment.radiance = {0.28f, 0.32f, 0.40f};
        SceneCamera& camera = build.scene.camera;
        const Vec3 eye{0, 0.75f, 4.6f}, target{0, 0.62f, 0};
        camera.name = "camera";
        camera.to_world = {look_at(eye, target)};
        camera.vertical_fov = radians(40);
        camera.focus = length(target - eye), camera.lens_radius = 0.02f;
    }

    void rolling() {
        const int rubber = build.material(glossy("wheel", {0.75f, 0.08f, 0.05f}, 0.35f));
        const int wheel = build.mesh(wheel_mesh(12), rubber, "wheel");
        for (int i = 0; i < 2; ++i) {
            const float radius = i == 0 ? 0.62f : 0.40f, angle = i == 0 ? -0.55f : 0.7f;
            Affine at = scale(radius);
            at.origin = {i == 0 ? -2.1f : 1.6f, -0.8f + 1.09f * radius, i == 0 ? -0.4f : 0.9f};
            // Rolls without sliding: the ground passes by as fast as the rim turns.
            const Vec3 velocity{-angle * radius * 1.09f, 0, 0};
            build.place(wheel, moving(at, velocity, {0, 0, 1}, angle));
        }
    }

    void turning() {
        const int steel = build.material(conductor("steel", {0.72f, 0.73f, 0.75f}, 0.25f));
        const int fan = build.mesh(fan_mesh(5), steel, "fan");
        const Vec3 at[] = {{-1.25f, 1.75f, -2.3f}, {1.35f, 1.85f, -2.3f}};
        for (int i = 0; i < 2; ++i)
            build.place(fan, moving(translate(at[i]) * scale(i == 0 ? 0.85f : 0.65f), {}, {0, 0, 1},
                                    i == 0 ? 0.5f : -1.6f));
    }

    void flying(size_t count) {
        std::array<int, 5> colors{};
        for (size_t i = 0; i < colors.size(); ++i) {
            const Vec3 a = hue(float(i) / 5), b{0.85f, 0.82f, 0.75f};
            colors[i] = painted(
                "ball " + std::to_string(i), 0.2f,
                [a, b](float u, float v) {
                    const bool stripe = (int(u * 8) + int(v * 4)) % 2 == 0;
                    return stripe ? a : b;
                },
                256, 128);
        }
        const int dots = painted(
            "die", 0.25f,
            [](float u, float v) {
                const float x = std::fabs(2 * u - 1), y = std::fabs(2 * v - 1);
                const bool dot = std::hypot(x, y) < 0.2f || std::hypot(x - 0.55f, y - 0.55f) < 0.2f;
                return dot ? Vec3{0.02f, 0.02f, 0.03f} : Vec3{0.80f, 0.78f, 0.72f};
            },
            128, 128);
        const int ball = build.mesh(sphere_mesh(48), colors[0], "ball");
        const int die = build.mesh(cube_mesh(), dots, "die");
        for (size_t i = 0; i < count; ++i) {
            const Dice dice(seed, 0, i);
            const bool round = dice(0) < 0.6f;
            const float radius = dice(1, 0.06f, 0.17f);
            Affine at = rotate(dice.direction(2), dice(4, 0, 2 * pi)) * scale(radius);
            const Vec3 middle = dice(5, {-2.0f, -0.45f, -2.2f}, {2.0f, 1.9f, 1.6f});
            const float angle = dice(8, -1.2f, 1.2f);
            const Vec3 axis = dice.direction(9);
            const Vec3 velocity = dice(11, {-0.45f, -0.15f, -0.3f}, {0.45f, 0.15f, 0.3f});
            at.origin = middle - velocity * 0.5f;
            std::vector<Affine> keys = moving(at, velocity, axis, angle);
            // A thrown thing falls: half g t^2 with a shutter of about a quarter of a second.
            for (size_t k = 0; k < keys.size(); ++k) {
                const float t = float(k) / float(keys.size() - 1);
                keys[k].origin.y += 0.12f * t * (1 - t);
            }
            build.place(round ? ball : die, keys, round ? colors[dice.below(14, 5)] : dots);
        }
    }
};

}  // namespace

Scene motion_scene(std::uint64_t seed, float size) {
    Motion motion;
    motion.seed = seed;
    motion.surroundings();
    motion.rolling();
    motion.turning();
    motion.flying(size_t(std::max(1.0f, 44 * size)));
    return std::move(motion.build.scene);
}

}  // namespace weft
