// A garden at dusk, from far to near: the sky at infinity, hills, a string of lanterns, hedges full
// of small lights, grass and flowers along a tiled path, cosmos in focus with butterflies about
// them, glazed balls on the path (one rolls), a branch and blossoms close to the lens.
#include "samples/analytic_garden.h"

#include <algorithm>

#include "samples/analytic_garden_backdrop.h"
#include "samples/analytic_garden_things.h"
#include "samples/analytic_paint.h"

namespace weft::analytic {
namespace {

constexpr float in_focus = 6.0f;

constexpr Vec3 pink{0.80f, 0.22f, 0.36f}, coral{0.88f, 0.26f, 0.15f}, white{0.85f, 0.78f, 0.76f},
    plum{0.38f, 0.07f, 0.26f}, cornflower{0.16f, 0.20f, 0.66f}, lilac{0.48f, 0.34f, 0.66f},
    butter{0.86f, 0.62f, 0.20f};
constexpr Vec3 green{0.10f, 0.17f, 0.045f}, fresh{0.22f, 0.30f, 0.07f}, deep{0.035f, 0.085f, 0.05f},
    straw{0.26f, 0.28f, 0.08f};

// Kinds of things, for their dice.
enum Kind {
    leaves,
    bulbs,
    blades,
    meadow_flowers,
    cosmos,
    foliage,
    petals,
    seeds,
    branch,
    near_blossoms,
    near_blades
};

void far(Planter& plant) {
    Primitive& field = plant.patch({0, ground, field_z}, {field_extent, 0, 0}, {0, 0, field_extent},
                                   nullptr, ground_texture);
    field.square = true;
    field.paint.light = {1, 1, 1};
    // Two ranges of hills and a line of trees.
    const struct {
        float z, height, base;
        Vec3 crest, foot;
        float hills, rough, phase;
    } ranges[] = {
        {900, 50, -6, {0.52f, 0.36f, 0.38f}, {0.95f, 0.58f, 0.40f}, 3, 0, 3.3f},
        {420, 22, -1, {0.22f, 0.20f, 0.23f}, {0.62f, 0.40f, 0.30f}, 4, 0, 8.1f},
        {80, 5.2f, 0.3f, {0.055f, 0.085f, 0.075f}, {0.26f, 0.20f, 0.14f}, 6, 0.35f, 1.7f}};
    for (const auto& r : ranges) {
        Primitive& p = plant.patch({0, r.base - 0.2f * r.height, r.z}, {r.z * 1.2f, 0, 0},
                                   {0, -r.height, 0}, hills_outline, hills_texture);
        p.square = true;
        p.paint.color = {r.crest, r.foot};
        p.paint.number = {r.hills, r.rough, r.phase};
        p.paint.light = {1, 1, 1};
    }
}

// Leaves in a rounded heap, dark within and below, sunlit above; lights hang among them.
void hedge(Planter& plant, int number, Vec3 middle, Vec3 extent, int leaf_count, int light_count) {
    for (int i = 0; i < leaf_count; ++i) {
        const Dice roll(leaves, 10000 * number + i);
        // A point in the unit ball: direction from a cube's, distance by volume.
        const Vec3 d = unit(roll(0, Vec3{-1, -1, -1}, Vec3{1, 1, 1})) * std::cbrt(roll(3, 0, 1));
        const float shell = dot(d, d);
        const float open = 0.30f + 1.5f * shell * (0.55f - 0.45f * d.y) * (1 - 0.25f * d.x);
        const float length = roll(4, 0.32f, 0.62f), width = length * roll(5, 0.4f, 0.6f);
        const Vec3 color = lerp(deep, roll.color(6, {green, fresh, green}), 0.3f + 0.7f * shell);
        Primitive& p = plant.leaf(roll, middle + d * extent,
                                  roll(7, Vec3{-1, -1.1f, -0.6f}, Vec3{1, 0.5f, 0.6f}), length,
                                  width, color, open);
        Planter::sway(p, roll(10, Vec3{-0.03f, -0.02f, 0}, Vec3{0.05f, 0.02f, 0}));
    }
    // What is behind the leaves stays dark.
    Primitive& core = plant.patch(middle + Vec3{0, 0.1f, extent.z * 0.2f}, {extent.x * 0.66f, 0, 0},
                                  {0, extent.y * 0.66f, 0}, nullptr, plain);
    core.paint.color[0] = {0.018f, 0.03f, 0.022f};
    core.paint.light = {0.6f, 0.6f, 0.6f};
    for (int i = 0; i < light_count; ++i) {
        const Dice roll(bulbs, 10000 * number + i);
        const float x = roll(0, -0.95f, 0.95f), y = roll(1, -0.95f, 0.7f);
        const float front = std::sqrt(std::max(0.0f, 1 - 0.8f * (x * x + y * y)));
        plant.light(
            middle + Vec3{x * extent.x, y * extent.y, -front * extent.z - 0.1f},
            roll(2, 0.024f, 0.042f),
            roll.color(3, {{17, 8.4f, 2.6f}, {19, 11, 4.2f}, {15, 5.6f, 1.9f}, {7, 9, 13}}));
    }
}

void lanterns(Planter& plant) {
    constexpr Vec3 warm[] = {{2.6f, 1.25f, 0.42f}, {2.3f, 0.75f, 0.40f}, {2.5f, 1.55f, 0.75f}};
    for (int i = 0; i < 8; ++i) {  // from the left, near, into the distance
        const float s = float(i) / 7, sag = 4 * s * (1 - s);
        Primitive& p = plant.sphere(
            {-4.6f + 5.6f * s + 0.9f * s * s, -2.0f + 0.15f * s + 0.42f * sag, 10.5f + 15 * s},
            0.31f, lantern_texture, warm[i % 3]);
        p.paint.number[0] = 4;
        p.origin_motion = {0.03f * float(i % 4) - 0.04f, 0, 0};
    }
    for (int i = 0; i < 46; ++i) {  // small bulbs on two strings from hedge to hedge
        const Dice roll(bulbs, i);
        const float s = (float(i % 23) + roll(0, 0.2f, 0.8f)) / 23, sag = 4 * s * (1 - s);
        const Vec3 at = i < 23 ? Vec3{-6.5f + 13 * s, -2.1f + 0.85f * sag, 17 + 3 * s}
                               : Vec3{5.2f - 9.5f * s, -2.35f + 1.15f * sag, 13 + 9 * s};
        plant.light(at, roll(1, 0.03f, 0.045f), roll.color(2, {{22, 12, 4.5f}, {26, 16, 7}}));
    }
}

// How far right of the path's middle: beyond its edge, most things near it.
float beside_path(const Dice& roll, int place, float z, float reach, float left) {
    const float side = roll(place, 0, 1) < left ? -1.0f : 1.0f;
    return path_middle(z) +
           side * (path_half + 0.1f + reach * roll(place + 1, 0, 1) * roll(place + 2, 0.1f, 1));
}

void meadow(Planter& plant) {
    for (int i = 0; i < 420; ++i) {
        const Dice roll(blades, i);
        const float z = 3.4f + 9 * std::pow(roll(0, 0, 1), 1.3f);
        const float length = roll(1, 0.18f, 0.55f) * (z < 4.3f ? 0.7f : 1.0f);
        Primitive& p = plant.blade(
            roll, {beside_path(roll, 2, z, 3.2f, 0.5f), ground + 0.02f, z}, roll(5, -0.5f, 0.5f),
            length, 0.05f, roll.color(6, {green, fresh, straw, green}), roll(7, 0.6f, 1.1f));
        Planter::sway(p, {roll(8, 0, 0.10f), 0, 0});
    }
    for (int i = 0; i < 110; ++i) {
        const Dice roll(meadow_flowers, i);
        const float z = roll(0, 4.6f, 13), x = beside_path(roll, 1, z, 4.5f, 0.45f);
        const Vec3 top{x + roll(4, -0.05f, 0.05f), ground - roll(5, 0.2f, 0.5f), z};
        plant.stem({x, ground, z}, top, 0.014f, green, 0.8f);
        plant.blossom(roll, top, {roll(6, -0.5f, 0.3f), roll(7, -1.2f, -0.3f), -1},
                      roll(8, 0.055f, 0.10f), roll(9, 0, 1) < 0.5f ? 5 : 8,
                      roll.color(10, {lilac, white, butter, cornflower, pink}), lilac,
                      roll(11, 0.8f, 1.15f));
    }
}

void flowers(Planter& plant) {
    const struct {
        Vec3 at;
        float radius;
        Vec3 rim, throat;
    } around[] = {{{0.62f, 0.22f, 6.25f}, 0.25f, white, {0.75f, 0.45f, 0.5f}},
                  {{2.55f, -0.12f, 6.5f}, 0.27f, pink, plum},
                  {{1.02f, 0.62f, 5.75f}, 0.20f, coral, {0.7f, 0.35f, 0.1f}},
                  {{2.18f, 0.52f, 5.9f}, 0.24f, white, {0.8f, 0.5f, 0.55f}},
                  {{1.98f, -0.62f, 7.4f}, 0.26f, lilac, plum},
                  {{0.98f, -0.42f, 7.2f}, 0.24f, coral, plum},
                  {{2.95f, 0.40f, 6.9f}, 0.26f, coral, plum},
                  {{1.32f, 0.02f, 6.9f}, 0.23f, pink, plum},
                  {{2.62f, -0.95f, 8.6f}, 0.27f, white, pink},
                  {{3.35f, -0.45f, 7.9f}, 0.27f, pink, plum},
                  {{0.35f, 0.58f, 6.6f}, 0.19f, lilac, plum},
                  {{1.72f, 0.72f, 5.5f}, 0.18f, pink, plum}};
    for (int i = 0; const auto& f : around) {
        const Dice roll(cosmos, i++);
        plant.stem({f.at.x + roll(0, -0.15f, 0.25f), ground, f.at.z + 0.1f},
                   f.at + Vec3{0, 0, 0.02f}, 0.022f, green, 0.9f);
        plant.blossom(roll, f.at, {roll(1, -0.7f, 0.1f), roll(2, -0.75f, 0.05f), -1}, f.radius, 8,
                      f.rim, f.throat, 1.15f);
    }
    // The one the butterfly sits on.
    constexpr Vec3 middle{1.62f, 0.10f, in_focus};
    plant.stem({1.72f, ground, in_focus + 0.1f}, middle + Vec3{0.01f, 0.02f, 0.03f}, 0.03f, fresh,
               0.9f);
    plant.large_blossom(Dice(cosmos, 100), middle, {-0.28f, -0.62f, -1}, 0.46f, 8,
                        {0.86f, 0.30f, 0.42f}, {0.62f, 0.08f, 0.22f}, 1.2f);
    // Narrow leaves between the stems, behind the blossoms but low in front.
    for (int i = 0; i < 120; ++i) {
        const Dice roll(foliage, i);
        const float low = roll(0, 0, 1);
        plant.leaf(roll, {roll(1, 0.3f, 3.4f), 0.30f + 0.75f * low, roll(2, 6.5f - low, 7.7f)},
                   roll(3, Vec3{-1, -1.2f, -0.5f}, Vec3{1, -0.1f, 0.3f}), roll(6, 0.2f, 0.46f),
                   roll(7, 0.03f, 0.09f), roll.color(8, {green, fresh, deep}),
                   roll(9, 0.45f, 1.0f));
    }
}

void fliers(Planter& plant) {
    const Wings monarch{{0.95f, 0.40f, 0.06f},
                        {0.88f, 0.24f, 0.03f},
                        {0.022f, 0.014f, 0.012f},
                        {0.92f, 0.86f, 0.78f}};
    const Wings blue{{0.10f, 0.42f, 0.86f},
                     {0.06f, 0.20f, 0.66f},
                     {0.012f, 0.014f, 0.03f},
                     {0.70f, 0.84f, 0.95f}};
    const Wings pale{
        {0.92f, 0.86f, 0.62f}, {0.90f, 0.78f, 0.42f}, {0.20f, 0.13f, 0.07f}, {0.95f, 0.9f, 0.8f}};
    plant.butterfly({1.50f, -0.23f, 5.88f}, {-0.45f, -0.72f, -0.35f}, {-0.25f, -0.45f, -0.9f},
                    0.66f, 0.30f, 0.05f, {}, monarch, 1.0f);
    plant.butterfly({-0.62f, -0.52f, 6.1f}, {0.55f, -0.55f, -0.1f}, {-0.2f, -0.5f, -0.85f}, 0.50f,
                    0.45f, 0.65f, {0.10f, -0.06f, 0}, blue, 1.1f);
    plant.butterfly({-2.35f, -0.62f, 7.1f}, {0.9f, -0.25f, 0.1f}, {0, -0.6f, -0.8f}, 0.44f, 0.5f,
                    1.1f, {0.36f, -0.12f, -0.1f}, pale, 1.7f);
    // Petals on the wind, turning, every third one fast.
    for (int i = 0; i < 44; ++i) {
        const Dice roll(petals, i);
        const float z = roll(0, 3.2f, 9.5f),
                    speed = i % 3 == 0 ? roll(1, 0.25f, 0.5f) : roll(1, 0.03f, 0.16f);
        const Vec3 at{roll(2, -0.52f, 0.5f) * z, roll(3, -0.24f, 0.12f) * z, z};
        Primitive& p = plant.shoot(at, roll(4, Vec3{-1, -1, -0.6f}, Vec3{1, 1, 0.6f}),
                                   roll(7, 0.11f, 0.18f), roll(8, 0.08f, 0.12f),
                                   roll(9, -1.2f, 1.2f), petal_outline, petal_texture, 1.25f);
        p.paint.color = {roll.color(10, {pink, coral, white, pink}), pink};
        p.paint.number[0] = 0.6f;
        p.origin_motion = roll(11, Vec3{0.7f, 0.12f, -0.3f}, Vec3{1.1f, 0.55f, 0.2f}) * speed;
        p.side_a_motion = roll(14, Vec3{0, -0.03f, -0.04f}, Vec3{0, 0.03f, 0.04f});
    }
    // Seeds afloat in the light.
    for (int i = 0; i < 60; ++i) {
        const Dice roll(seeds, i);
        const float z = roll(0, 2.6f, 11);
        Primitive& p =
            plant.light({roll(1, -0.5f, 0.5f) * z, roll(2, -0.22f, 0.2f) * z, z},
                        roll(3, 0.006f, 0.013f), roll.color(4, {{7, 4.6f, 2.4f}, {5, 3.6f, 2.2f}}));
        p.origin_motion = roll(5, Vec3{-0.02f, -0.05f, 0}, Vec3{0.09f, 0.03f, 0});
    }
}

void balls(Planter& plant) {
    const auto ball = [&](Vec3 at, float radius, Vec3 glaze, Vec3 mark, float pattern, float turn,
                          Vec3 motion) {
        Primitive& p = plant.sphere(at, radius, ball_texture, glaze, mark);
        p.paint.number = {pattern, turn};
        p.paint.light = {0.9f, 0.9f, 0.9f};
        p.origin_motion = motion;
    };
    ball({-1.42f, ground - 0.37f, 6.15f}, 0.37f, {0.62f, 0.52f, 0.40f}, {0.05f, 0.19f, 0.24f}, 0,
         0.5f, {});
    ball({-0.72f, ground - 0.21f, 5.45f}, 0.21f, {0.05f, 0.16f, 0.33f}, {0.80f, 0.68f, 0.50f}, 1,
         -0.4f, {0.12f, 0, -0.04f});
}

void close(Planter& plant) {
    for (int i = 0; i < 26; ++i) {  // a branch from the upper right
        const Dice roll(branch, i);
        const float s = float(i) / 26;
        const Vec3 at = Vec3{1.85f - 0.95f * s, -0.86f + 0.20f * s * s, 3.3f} +
                        roll(0, Vec3{-0.07f, -0.08f, -0.3f}, Vec3{0.07f, 0.06f, 0.5f});
        Primitive& p =
            plant.leaf(roll, at, roll(3, Vec3{-0.9f, -0.1f, -0.4f}, Vec3{0.2f, 1.0f, 0.4f}),
                       roll(6, 0.22f, 0.36f), roll(7, 0.10f, 0.15f),
                       roll.color(8, {deep, green, fresh}), roll(9, 0.4f, 1.0f));
        Planter::sway(p, roll(10, Vec3{-0.004f, 0, 0}, Vec3{0.014f, 0.008f, 0}));
    }
    const struct {
        Vec3 at;
        float radius;
        Vec3 rim, throat;
    } blossoms[] = {{{-0.98f, 0.46f, 2.30f}, 0.155f, coral, butter},
                    {{-1.22f, 0.16f, 2.75f}, 0.15f, pink, plum},
                    {{-0.66f, 0.72f, 2.15f}, 0.12f, butter, coral},
                    {{1.42f, 0.86f, 3.25f}, 0.14f, lilac, plum},
                    {{1.72f, 0.64f, 3.6f}, 0.15f, white, lilac},
                    {{1.05f, 1.0f, 3.4f}, 0.10f, butter, coral}};
    for (int i = 0; const auto& f : blossoms) {
        plant.stem({f.at.x - 0.04f, 1.0f, f.at.z + 0.02f}, f.at + Vec3{0, 0, 0.01f}, 0.012f, green,
                   0.7f);
        plant.blossom(Dice(near_blossoms, i++), f.at, {0.3f, -0.45f, -1}, f.radius, 8, f.rim,
                      f.throat, 1.0f);
    }
    for (int i = 0; i < 46; ++i) {
        const Dice roll(near_blades, i);
        const float z = roll(0, 1.9f, 3.0f), reach = roll(1, 0.42f, 0.54f) * z;
        const float x =
            roll(2, 0, 1) < 0.7f ? roll(3, 0, 0.35f) - reach : reach + roll(3, -0.1f, 0.1f);
        Primitive& p =
            plant.blade(roll, {x, 0.40f * z, z}, roll(4, -0.35f, 0.35f), roll(5, 0.18f, 0.5f),
                        0.028f, roll.color(6, {green, fresh, deep}), roll(7, 0.5f, 0.95f));
        Planter::sway(p, {roll(8, 0, 0.03f), 0, 0});
    }
}

}  // namespace

Scene garden_scene(const AnalyticOptions& o) {
    Scene scene;
    scene.camera = {.scale = 1.744f * float(o.height),
                    .center_x = 0.5f * float(o.width),
                    .center_y = 0.4f * float(o.height),
                    .lens_radius = 0.13f * o.aperture,
                    .focus = in_focus};
    scene.sky = dusk_sky;
    Planter plant(scene);
    far(plant);
    hedge(plant, 1, {-5.6f, -0.15f, 11.5f}, {2.9f, 1.6f, 1.3f}, 340, 26);
    hedge(plant, 2, {5.9f, -0.45f, 11.0f}, {2.9f, 1.9f, 1.3f}, 340, 26);
    hedge(plant, 3, {-3.3f, 0.55f, 8.2f}, {0.9f, 0.65f, 0.6f}, 110, 8);
    lanterns(plant);
    meadow(plant);
    flowers(plant);
    fliers(plant);
    balls(plant);
    close(plant);
    for (Primitive& p : scene.primitives) {
        p.origin_motion = p.origin_motion * o.shutter;
        p.side_a_motion = p.side_a_motion * o.shutter;
        p.side_b_motion = p.side_b_motion * o.shutter;
    }
    return scene;
}

}  // namespace weft::analytic
