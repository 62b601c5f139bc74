#include "render/chess_pieces.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/affine.h"
#include "render/shapes.h"

namespace weft {
namespace {

using Profile = std::vector<Vec2>;

// The foot that all share, up to a waist of radius `waist` at height `height`.
Profile foot(float waist, float height) {
    return {
        {0, 0},         {0.36f, 0},     {0.38f, 0.03f}, {0.38f, 0.10f},         {0.33f, 0.14f},
        {0.33f, 0.17f}, {0.29f, 0.22f}, {0.22f, 0.27f}, {waist * 1.15f, 0.36f}, {waist, height}};
}

// A collar of two rims at `height`, then `above` (heights counted from the collar).
Profile with_collar(Profile profile, float height, float radius, const Profile& above) {
    profile.push_back({radius * 0.75f, height - 0.03f});
    profile.push_back({radius, height});
    profile.push_back({radius * 0.95f, height + 0.03f});
    profile.push_back({radius * 0.62f, height + 0.05f});
    for (const Vec2 p : above) profile.push_back({p.x, p.y + height + 0.05f});
    return profile;
}

Profile ball(float radius, float height) {
    Profile points;
    for (int i = 1; i <= 7; ++i) {
        const float a = -pi / 2 + 0.45f + (pi - 0.45f) * float(i) / 7;
        points.push_back(
            {i == 7 ? 0.0f : radius * std::cos(a), height + radius * (1 + std::sin(a))});
    }
    return points;
}

Mesh turned(const Profile& profile, int segments) {
    return lathe_mesh(smooth_profile(profile, 4), segments, 0.7f);
}

Mesh rook(int segments) {
    Profile p = with_collar(foot(0.19f, 0.72f), 0.80f, 0.29f, {{0.22f, 0.0f}, {0.27f, 0.04f}});
    Mesh mesh = turned(p, segments);
    // A straight wall round a sunken floor, its top cut into six.
    const Profile wall = {
        {0.27f, 0.89f}, {0.28f, 1.02f}, {0.18f, 1.02f}, {0.18f, 0.95f}, {0, 0.95f}};
    append(mesh, lathe_mesh(wall, segments, 0.3f));
    for (int i = 0; i < 6; ++i)
        append(mesh, cube_mesh(),
               rotate({0, 1, 0}, float(i) * pi / 3) * translate({0, 1.06f, 0.23f}) *
                   scale(Vec3{0.075f, 0.06f, 0.045f}));
    return mesh;
}

Mesh knight(int segments) {
    Mesh mesh = turned(with_collar(foot(0.24f, 0.34f), 0.38f, 0.28f, {{0.20f, 0.02f}, {0, 0.03f}}),
                       segments);
    const Vec3 spine[] = {{0, 0.36f, 0.03f},  {0, 0.55f, 0.12f},  {0, 0.75f, 0.14f},
                          {0, 0.95f, 0.08f},  {0, 1.08f, -0.04f}, {0, 1.06f, -0.18f},
                          {0, 0.98f, -0.29f}, {0, 0.91f, -0.37f}, {0, 0.885f, -0.40f}};
    const float radii[] = {0.24f, 0.22f, 0.20f, 0.19f, 0.17f, 0.13f, 0.105f, 0.085f, 0.02f};
    append(mesh, tube_mesh(spine, radii, std::max(segments / 2, 8)), scale(Vec3{0.72f, 1, 1}));
    const Profile cone = {{0.05f, 0}, {0.045f, 0.05f}, {0, 0.16f}};
    for (const float side : {-1.0f, 1.0f}) {
        append(mesh, lathe_mesh(cone, std::max(segments / 4, 6)),
               translate({side * 0.06f, 1.17f, 0.0f}) * rotate({0, 0, 1}, -0.2f * side));
        append(mesh, sphere_mesh(std::max(segments / 4, 8)),
               translate({side * 0.10f, 1.06f, -0.17f}) * scale(0.028f));
    }
    // The mane: a row of discs behind the neck.
    for (int i = 0; i < 5; ++i)
        append(mesh, sphere_mesh(std::max(segments / 4, 8)),
               translate({0, 0.62f + 0.12f * float(i), 0.32f - 0.035f * float(i * i) * 0.5f}) *
                   scale(Vec3{0.035f, 0.08f, 0.06f}));
    return mesh;
}

}  // namespace

Mesh chess_piece_mesh(ChessPiece piece, int segments) {
    switch (piece) {
        case ChessPiece::pawn:
            return turned(with_collar(foot(0.13f, 0.62f), 0.68f, 0.24f, ball(0.19f, -0.05f)),
                          segments);
        case ChessPiece::rook:
            return rook(segments);
        case ChessPiece::knight:
            return knight(segments);
        case ChessPiece::bishop: {
            Profile mitre = {{0.12f, 0.02f}, {0.19f, 0.12f},  {0.18f, 0.24f}, {0.11f, 0.36f},
                             {0.05f, 0.42f}, {0.055f, 0.46f}, {0.03f, 0.50f}, {0, 0.51f}};
            return turned(with_collar(foot(0.14f, 0.78f), 0.88f, 0.25f, mitre), segments);
        }
        case ChessPiece::queen: {
            Profile crown = {{0.15f, 0.02f}, {0.19f, 0.18f}, {0.26f, 0.34f},
                             {0.22f, 0.35f}, {0.17f, 0.33f}, {0.08f, 0.40f},
                             {0.06f, 0.43f}, {0.05f, 0.48f}, {0, 0.50f}};
            Mesh mesh = turned(with_collar(foot(0.15f, 0.95f), 1.08f, 0.27f, crown), segments);
            for (int i = 0; i < 9; ++i)
                append(mesh, sphere_mesh(std::max(segments / 4, 8)),
                       rotate({0, 1, 0}, float(i) * 2 * pi / 9) * translate({0, 1.48f, 0.24f}) *
                           scale(0.04f));
            return mesh;
        }
        case ChessPiece::king: {
            Profile crown = {{0.16f, 0.02f}, {0.18f, 0.18f}, {0.24f, 0.36f}, {0.22f, 0.39f},
                             {0.12f, 0.44f}, {0.04f, 0.46f}, {0, 0.46f}};
            Mesh mesh = turned(with_collar(foot(0.16f, 1.02f), 1.18f, 0.28f, crown), segments);
            append(mesh, cube_mesh(),
                   translate({0, 1.79f, 0}) * scale(Vec3{0.035f, 0.13f, 0.035f}));
            append(mesh, cube_mesh(),
                   translate({0, 1.82f, 0}) * scale(Vec3{0.10f, 0.035f, 0.034f}));
            return mesh;
        }
    }
    return {};
}

}  // namespace weft
