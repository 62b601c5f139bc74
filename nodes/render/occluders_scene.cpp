// occluders: a leafy tree, a picket fence and a rope of rings, and one large lamp low behind them.
// The ground and the wall that catch the shadows are plain, so that all detail is visibility:
// sharp where things touch the ground, soft where their shadow has gone far.
#include <algorithm>
#include <cmath>

#include "render/foliage.h"
#include "render/procedural_scene.h"
#include "render/shapes.h"

namespace weft {
namespace {

struct Tree {
    SceneBuilder& build;
    std::uint64_t seed;
    Mesh wood{};
    std::vector<Affine> leaves{};
    size_t limbs = 0;

    // A limb from `from` along `ahead`, with smaller ones at its end and sides.
    void grow(Vec3 from, Vec3 ahead, float span, float radius, int level) {
        const Dice dice(seed, 0, limbs++);
        std::vector<Vec3> points = {from};
        std::vector<float> radii = {radius};
        Vec3 direction = ahead;
        constexpr int pieces = 5;
        for (int i = 1; i <= pieces; ++i) {
            direction = unit(direction + 0.22f * dice.direction(3 * i) + Vec3{0, 0.04f, 0});
            points.push_back(points.back() + direction * (span / pieces));
            radii.push_back(radius * (1 - 0.45f * float(i) / pieces));
        }
        append(wood, tube_mesh(points, radii, level > 2 ? 6 : 12));
        if (level >= 4) {
            for (int i = 0; i < 9; ++i) leaf(points[size_t(1 + i % pieces)], dice, i);
            return;
        }
        const int branches = level == 0 ? 5 : 4;
        for (int i = 0; i < branches; ++i) {
            const int place = 100 + 8 * i;
            const Vec3 side = dice.direction(place);
            const Vec3 outward = unit(side - direction * dot(side, direction) + Vec3{1e-4f, 0, 0});
            const Vec3 next = unit(direction * 0.75f + outward * dice(place + 2, 0.6f, 1.0f));
            const size_t at =
                i == 0 ? pieces : size_t(dice(place + 3, 2.5f, float(pieces) + 0.99f));
            grow(points[at], next, span * dice(place + 4, 0.62f, 0.80f), radii[at] * 0.72f,
                 level + 1);
        }
    }

    void leaf(Vec3 at, const Dice& dice, int i) {
        const int place = 200 + 10 * i;
        Affine turned = rotate(dice.direction(place), dice(place + 2, 0, 2 * pi)) *
                        scale(dice(place + 3, 0.09f, 0.15f));
        turned.origin = at + dice.direction(place + 4) * 0.06f;
        leaves.push_back(turned);
    }
};

}  // namespace

Scene occluders_scene(std::uint64_t seed, float size) {
    SceneBuilder build;
    const int plaster = build.material(diffuse("plaster", {0.78f, 0.76f, 0.72f}));
    build.place(build.mesh(plane_mesh(), plaster, "ground"), scale(14));
    build.place(build.mesh(wall_mesh(), plaster, "wall"), translate({0, 4, -2.9f}) * scale(14));

    const int bark = build.material(diffuse("bark", {0.20f, 0.14f, 0.10f}));
    const int green = build.material(glossy("leaf", {0.22f, 0.42f, 0.07f}, 0.5f));
    const int spring = build.material(glossy("young leaf", {0.50f, 0.60f, 0.12f}, 0.5f));
    const int leaf = build.mesh(leaf_mesh(0.55f, 0.2f, 0.1f), green, "leaf");

    // One tree at size 1, a row of them beyond.
    const int trees = std::max(1, int(std::lround(size)));
    for (int k = 0; k < trees; ++k) {
        Tree tree{build, mix(seed + std::uint64_t(k) * 977)};
        tree.grow({0, -0.02f, 0}, {0.05f, 1, 0}, 1.25f, 0.11f, 0);
        const float x = -1.1f + (k % 2 ? 1.0f : -1.0f) * 2.2f * float((k + 1) / 2);
        const Affine place = translate({x, 0, -1.3f}) * scale(k == 0 ? 1.0f : 0.85f);
        build.place(build.mesh(tree.wood, bark, "wood"), place);
        const size_t keep =
            size < 1 ? size_t(float(tree.leaves.size()) * size) : tree.leaves.size();
        for (size_t i = 0; i < keep; ++i)
            build.place(leaf, place * tree.leaves[i], i % 5 == 0 ? spring : green);
    }

    const int paint = build.material(glossy("paint", {0.80f, 0.20f, 0.10f}, 0.4f));
    Mesh picket = cube_mesh();
    const int board = build.mesh(picket, paint, "picket");
    for (int i = 0; i < 15; ++i) {
        const Dice dice(seed, 1, size_t(i));
        build.place(board, translate({0.55f + 0.17f * float(i), 0.42f, -1.0f + 0.12f * float(i)}) *
                               rotate({0, 1, 0}, -0.6f) *
                               rotate({0, 0, 1}, dice(0, -0.06f, 0.06f)) *
                               scale(Vec3{0.05f, dice(1, 0.38f, 0.45f), 0.012f}));
    }
    for (const float h : {0.22f, 0.60f}) {
        const Vec3 from{0.45f, h, -1.09f}, to{3.05f, h, 0.74f};
        const Affine along = look_at((from + to) * 0.5f, to);
        build.place(board, along * scale(Vec3{0.012f, 0.03f, 0.5f * length(to - from)}));
    }

    // A hanging chain whose links show the ground between them.
    const int brass = build.material(conductor("brass", {0.91f, 0.73f, 0.40f}, 0.25f));
    const int ring = build.mesh(torus_mesh(0.16f, 36), brass, "ring");
    for (int i = 0; i < 26; ++i) {
        const float s = float(i) / 25, x = -2.9f + 5.2f * s;
        const float sag = 1.55f + 1.1f * (2 * s - 1) * (2 * s - 1);
        const float slope = std::atan(1.1f * 4 * (2 * s - 1) / 5.2f);
        build.place(ring, translate({x, sag, 0.25f}) * rotate({0, 0, 1}, slope) *
                              rotate({1, 0, 0}, i % 2 ? 0.0f : pi / 2) *
                              scale(Vec3{0.14f, 0.09f, 0.09f}));
    }

    build.quad_light("lamp", {3.4f, 4.0f, 4.2f}, {-0.2f, 0.6f, -1.2f}, 0.45f, 0.45f,
                     {190, 168, 140});
    build.scene.environment.radiance = Vec3{0.16f, 0.20f, 0.27f};
    build.scene.environment.visible = true;

    SceneCamera& camera = build.scene.camera;
    const Vec3 eye{-0.3f, 1.8f, 5.2f}, target{-0.1f, 1.25f, -1};
    camera.name = "camera";
    camera.to_world = {look_at(eye, target)};
    camera.vertical_fov = radians(38);
    camera.focus = length(target - eye), camera.lens_radius = 0.015f;
    return std::move(build.scene);
}

}  // namespace weft
