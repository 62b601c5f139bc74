// chess: a middle game on a polished board, seen from close by through a wide lens, so that most of
// it is out of focus. A bishop is being pulled back and a captured pawn rolls while the shutter is
// open. Squares are 5.5 cm.
#include <algorithm>
#include <array>
#include <cmath>

#include "render/chess_pieces.h"
#include "render/procedural_scene.h"
#include "render/scene_builder.h"
#include "render/shapes.h"

namespace weft {
namespace {

constexpr float square = 0.055f;

// The middle of a square: file 0..7 to the right, rank 0..7 away from the viewer.
Vec3 on(int file, int rank) {
    return {(float(file) - 3.5f) * square, 0, (3.5f - float(rank)) * square};
}

struct Standing {
    ChessPiece piece;
    int file, rank;
    bool white;
};

// A quiet position out of the opening; `seed` above 1 takes pieces away and moves pawns on.
std::vector<Standing> position(std::uint64_t seed) {
    using enum ChessPiece;
    std::vector<Standing> all = {
        {rook, 0, 0, true},    {queen, 3, 0, true},   {rook, 5, 0, true},   {king, 6, 0, true},
        {pawn, 0, 1, true},    {pawn, 1, 1, true},    {pawn, 5, 1, true},   {pawn, 6, 1, true},
        {pawn, 7, 1, true},    {pawn, 2, 2, true},    {knight, 5, 2, true}, {bishop, 2, 3, true},
        {pawn, 3, 3, true},    {pawn, 4, 3, true},    {knight, 3, 1, true}, {pawn, 4, 4, false},
        {knight, 2, 5, false}, {knight, 5, 5, false}, {pawn, 3, 5, false},  {bishop, 6, 3, false},
        {pawn, 0, 6, false},   {pawn, 1, 6, false},   {pawn, 2, 6, false},  {pawn, 5, 6, false},
        {pawn, 6, 6, false},   {pawn, 7, 5, false},   {rook, 0, 7, false},  {queen, 3, 7, false},
        {king, 4, 7, false},   {rook, 7, 7, false},   {bishop, 4, 6, false}};
    if (seed == 1) return all;
    std::vector<Standing> left;
    for (size_t i = 0; i < all.size(); ++i) {
        const Dice dice(seed, 1, i);
        if (all[i].piece != king && dice(0) < 0.25f) continue;
        const int ahead = all[i].rank + (all[i].white ? 1 : -1);
        const bool free = std::none_of(all.begin(), all.end(), [&](const Standing& other) {
            return other.file == all[i].file && other.rank == ahead;
        });
        if (all[i].piece == pawn && free && dice(1) < 0.5f) all[i].rank = ahead;
        left.push_back(all[i]);
    }
    return left;
}

int board_texture(SceneBuilder& build, std::uint64_t seed) {
    return build.texture("board", 1024, 1024, [=](float u, float v) {
        // Eight squares and a border of half a square.
        const float x = u * 9 - 0.5f, y = v * 9 - 0.5f;
        const int i = int(std::floor(x)), j = int(std::floor(y));
        const bool border = x < 0 || y < 0 || x >= 8 || y >= 8;
        const bool light = !border && (i + j) % 2 == 0;
        const float grain = light ? noise(x * 2 + 7 * float(j), y * 14, seed, 4)
                                  : noise(x * 14, y * 2 + 5 * float(i), seed + 3, 4);
        const float gap = std::min(std::fabs(x - std::round(x)), std::fabs(y - std::round(y)));
        const Vec3 pale = lerp(Vec3{0.50f, 0.33f, 0.17f}, Vec3{0.68f, 0.50f, 0.30f}, grain);
        const Vec3 dark = lerp(Vec3{0.055f, 0.022f, 0.012f}, Vec3{0.13f, 0.06f, 0.03f}, grain);
        const Vec3 frame = lerp(Vec3{0.04f, 0.015f, 0.01f}, Vec3{0.10f, 0.04f, 0.02f}, grain);
        const Vec3 color = border ? frame : light ? pale : dark;
        return !border && gap < 0.012f ? color * 0.45f : color;
    });
}

int table_texture(SceneBuilder& build, std::uint64_t seed) {
    return build.texture("table", 512, 512, [=](float u, float v) {
        const float plank = std::floor(u * 6);
        const float seam = std::fabs(std::remainder(u * 6, 1.0f)) < 0.012f ? 0.35f : 1.0f;
        const float grain = noise(u * 90, v * 5 + 9 * plank, seed + 5, 4);
        const float tone = 0.75f + 0.5f * noise(plank * 3.7f, 0.5f, seed + 6, 1);
        return lerp(Vec3{0.09f, 0.045f, 0.02f}, Vec3{0.20f, 0.11f, 0.055f}, grain) * (seam * tone);
    });
}

}  // namespace

Scene chess_scene(std::uint64_t seed, float size) {
    SceneBuilder build;
    const int segments = int(std::clamp(48 * std::sqrt(size), 12.0f, 1024.0f));

    Material table = glossy("table", {1, 1, 1}, 0.35f);
    table.base_color_map.file = table_texture(build, seed);
    table.base_color_map.scale = {4, 4};
    build.place(build.mesh(plane_mesh(), build.material(table), "table"),
                translate({0, -0.02f, 0}) * scale(4));
    Material board = glossy("board", {1, 1, 1}, 0.12f);
    board.base_color_map.file = board_texture(build, seed);
    const int top = build.material(board);
    const float half = 4.5f * square;
    build.place(build.mesh(plane_mesh(), top, "board"), scale(half));
    const int frame = build.material(glossy("frame", {0.06f, 0.025f, 0.015f}, 0.2f));
    build.place(build.mesh(cube_mesh(), frame, "frame"),
                translate({0, -0.0101f, 0}) * scale(Vec3{half, 0.01f, half}));

    const int white = build.material(glossy("white", {0.78f, 0.66f, 0.46f}, 0.22f));
    const int black = build.material(glossy("black", {0.035f, 0.018f, 0.014f}, 0.15f));
    std::array<int, 6> meshes{};
    const char* names[] = {"pawn", "rook", "knight", "bishop", "queen", "king"};
    for (int i = 0; i < 6; ++i)
        meshes[size_t(i)] = build.mesh(chess_piece_mesh(ChessPiece(i), segments), white, names[i]);

    const auto standing = position(seed);
    for (size_t i = 0; i < standing.size(); ++i) {
        const Standing& s = standing[i];
        const Dice dice(seed, 2, i);
        Affine at = rotate({0, 1, 0}, (s.white ? 0 : pi) + dice(0, -0.25f, 0.25f)) * scale(square);
        at.origin = on(s.file, s.rank) + dice(1, {-0.004f, 0, -0.004f}, {0.004f, 0, 0.004f});
        const bool moved = s.piece == ChessPiece::bishop && !s.white && s.file == 6;
        const Vec3 velocity = moved ? Vec3{0.5f * square, 0, -0.5f * square} : Vec3{};
        build.place(meshes[size_t(s.piece)], moved ? moving(at, velocity) : std::vector<Affine>{at},
                    s.white ? white : black);
    }
    // Taken pieces beside the board; the pawn has just been put down and rolls.
    Affine lying = rotate({0, 0, 1}, pi / 2) * scale(square);
    lying.origin = {0.29f, 0.38f * square - 0.02f, 0.10f};
    build.place(meshes[0], moving(lying, {0.012f, 0, 0.03f}, {1, 0, 0}, 1.4f), black);
    Affine knight = rotate({0, 1, 0}, 2.2f) * scale(square);
    knight.origin = {-0.31f, -0.02f, 0.06f};
    build.place(meshes[2], knight, black);

    build.quad_light("window", {-0.9f, 1.0f, 0.25f}, {0, 0, 0}, 0.45f, 0.35f, {14, 15, 17});
    build.quad_light("lamp", {0.7f, 0.7f, -0.8f}, {0, 0.05f, 0}, 0.16f, 0.16f, {44, 28, 15});
    build.sky([](Vec3 d) {
        const float up = 0.5f + 0.5f * d.y;
        return lerp(Vec3{0.05f, 0.035f, 0.025f}, Vec3{0.16f, 0.17f, 0.20f}, up);
    });

    SceneCamera& camera = build.scene.camera;
    const Vec3 eye{0.13f, 0.145f, 0.335f}, target = on(4, 3) + Vec3{0, 0.03f, 0};
    camera.name = "camera";
    camera.to_world = {look_at(eye, target)};
    camera.vertical_fov = radians(36);
    camera.focus = dot(on(5, 2) + Vec3{0, 0.05f, 0} - eye, unit(target - eye));
    camera.lens_radius = 0.012f, camera.blades = 7;
    return std::move(build.scene);
}

}  // namespace weft
