// cornell: a closed box with coloured walls after the one of Cornell (Goral et al. 1984), with a
// block of rough metal and a ball of glass in place of its white blocks. Pinhole, still: what is
// hard here is light that comes round corners. Half the walls' distance is 1.
#include <algorithm>
#include <cmath>

#include "render/procedural_scene.h"
#include "render/scene_builder.h"
#include "render/shapes.h"

namespace weft {

Scene cornell_scene(std::uint64_t seed, float size) {
    SceneBuilder build;
    const Dice dice(seed, 0, 0);
    const int white = build.material(diffuse("white", {0.73f, 0.73f, 0.73f}));
    const int red = build.material(diffuse("red", {0.63f, 0.06f, 0.05f}));
    const int green = build.material(diffuse("green", {0.14f, 0.45f, 0.09f}));
    const int metal = build.material(conductor("metal", {0.95f, 0.79f, 0.55f}, 0.3f));
    const int clear = build.material(glass("glass"));

    const int wall = build.mesh(wall_mesh(), white, "wall");
    build.place(wall, translate({0, 1, -1}));
    build.place(wall, translate({0, 0, 0}) * rotate({1, 0, 0}, -pi / 2)).name = "floor";
    build.place(wall, translate({0, 2, 0}) * rotate({1, 0, 0}, pi / 2)).name = "ceiling";
    build.place(wall, translate({-1, 1, 0}) * rotate({0, 1, 0}, pi / 2), red).name = "left wall";
    build.place(wall, translate({1, 1, 0}) * rotate({0, 1, 0}, -pi / 2), green).name = "right wall";

    // Another seed turns the block and moves the ball; 1 is the picture as it is known.
    const float turn = seed == 1 ? 0.90f : dice(0, -0.6f, 0.6f);
    const Vec3 shift = seed == 1 ? Vec3{} : dice(1, {-0.08f, 0, -0.2f}, {0.08f, 0, 0.1f});
    build.place(build.mesh(cube_mesh(), metal, "block"), translate({-0.36f, 0.6f, -0.34f}) *
                                                             rotate({0, 1, 0}, turn) *
                                                             scale(Vec3{0.3f, 0.6f, 0.3f}));
    const int segments = int(std::clamp(128 * std::sqrt(size), 16.0f, 2048.0f));
    build.place(build.mesh(sphere_mesh(segments), clear, "ball"),
                translate(Vec3{0.42f, 0.36f, 0.32f} + shift) * scale(0.36f));

    build.quad_light("ceiling light", {0, 1.995f, -0.05f}, {0, 0, -0.05f}, 0.32f, 0.26f,
                     {17, 12.5f, 7.5f});

    SceneCamera& camera = build.scene.camera;
    camera.name = "camera";
    camera.to_world = {look_at({0, 1, 3.85f}, {0, 1, 0})};
    camera.vertical_fov = 2 * std::atan(1.03f / 2.85f);
    camera.focus = 3.85f;
    return std::move(build.scene);
}

}  // namespace weft
