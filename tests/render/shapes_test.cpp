// Shapes: areas and volumes as geometry says, outward faces, unit normals, upright textures.
#include "render/shapes.h"

#include <cmath>

#include "render/affine.h"
#include "run_node.h"

namespace weft {
namespace {

double area(const Mesh& mesh) {
    double sum = 0;
    for (const auto& t : mesh.triangles) {
        const Vec3 a = mesh.positions[t[0]];
        sum += 0.5 * length(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
    }
    return sum;
}
// Positive where triangles are counter-clockwise from outside.
double volume(const Mesh& mesh) {
    double sum = 0;
    for (const auto& t : mesh.triangles)
        sum += dot(mesh.positions[t[0]], cross(mesh.positions[t[1]], mesh.positions[t[2]])) / 6;
    return sum;
}

void expect_sound(const Mesh& mesh) {
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
    ASSERT_EQ(mesh.uv.size(), mesh.positions.size());
    for (const Vec3 n : mesh.normals) EXPECT_NEAR(length(n), 1, 1e-4);
    for (const auto& t : mesh.triangles) {
        for (const std::uint32_t v : t) ASSERT_LT(v, mesh.positions.size());
        const Vec3 a = mesh.positions[t[0]];
        const Vec3 face = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
        for (const std::uint32_t v : t) EXPECT_GT(dot(face, mesh.normals[v]), 0);
    }
}

TEST(Shapes, HaveTheirAreaAndVolume) {
    for (const Mesh& mesh : {plane_mesh(3), wall_mesh(2), disc_mesh(200), cube_mesh(),
                             sphere_mesh(128), torus_mesh(0.25f, 150)})
        expect_sound(mesh);
    EXPECT_NEAR(area(plane_mesh(3)), 4, 1e-5);
    EXPECT_NEAR(area(disc_mesh(200)), pi, 1e-3);
    EXPECT_NEAR(volume(cube_mesh()), 8, 1e-5);
    EXPECT_NEAR(volume(sphere_mesh(128)), 4 * pi / 3, 0.01);
    EXPECT_NEAR(volume(torus_mesh(0.25f, 150)), 2 * pi * pi * 0.0625, 0.01);
}

TEST(Shapes, ALatheTurnsACylinder) {
    const Vec2 profile[] = {{0, -1}, {0.5f, -1}, {0.5f, 1}, {0, 1}};
    const Mesh mesh = lathe_mesh(profile, 256);
    expect_sound(mesh);
    EXPECT_NEAR(volume(mesh), 0.25 * pi * 2, 1e-3);
    // Its rims are sharper than the crease: every normal is along the axis or across it.
    for (const Vec3 n : mesh.normals)
        EXPECT_TRUE(std::fabs(n.y) > 0.999f || std::fabs(n.y) < 1e-3f);
}

TEST(Shapes, ATubeFollowsItsPoints) {
    const Vec3 points[] = {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}};
    const float radii[] = {0.1f, 0.1f, 0.1f};
    const Mesh mesh = tube_mesh(points, radii, 64);
    expect_sound(mesh);
    EXPECT_NEAR(area(mesh), 2 * pi * 0.1 * 2, 1e-2);
}

TEST(Shapes, TexturesAreUprightFromOutside) {
    // At each vertex neighbourhood of the wall: u grows to the right (+x), v downwards (-y).
    const Mesh wall = wall_mesh();
    for (size_t i = 0; i < wall.positions.size(); ++i) {
        EXPECT_FLOAT_EQ(wall.uv[i].x, 0.5f + 0.5f * wall.positions[i].x);
        EXPECT_FLOAT_EQ(wall.uv[i].y, 0.5f - 0.5f * wall.positions[i].y);
    }
    // Handedness: (dp/du x dp/dv) points inwards everywhere, as on the wall.
    for (const Mesh& mesh :
         {plane_mesh(), wall_mesh(), cube_mesh(), sphere_mesh(32), disc_mesh(16)})
        for (const auto& t : mesh.triangles) {
            const Vec2 a = mesh.uv[t[0]], b = mesh.uv[t[1]], c = mesh.uv[t[2]];
            const float turn = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
            EXPECT_LT(turn, 0);
        }
}

TEST(Shapes, AppendMirrorsWithoutTurningInsideOut) {
    Mesh mesh;
    append(mesh, cube_mesh(), scale(Vec3{-2, 1, 1}));
    expect_sound(mesh);
    EXPECT_NEAR(volume(mesh), 16, 1e-4);
}

TEST(Shapes, MadeNormalsOfASphereAreItsRadii) {
    Mesh mesh = sphere_mesh(128);
    // Without the seam's and the poles' doubled vertices.
    make_normals(mesh);
    size_t inner = 0;
    for (size_t i = 0; i < mesh.positions.size(); ++i)
        if (mesh.uv[i].x > 0 && mesh.uv[i].x < 1 && mesh.uv[i].y > 0.1f && mesh.uv[i].y < 0.9f) {
            EXPECT_GT(dot(mesh.normals[i], mesh.positions[i]), 0.9999f);
            ++inner;
        }
    EXPECT_GT(inner, 4000u);
}

TEST(Affine, LooksAlongMinusZ) {
    const Affine camera = look_at({1, 2, 3}, {1, 2, -5});
    EXPECT_EQ(camera.z, (Vec3{0, 0, 1}));
    EXPECT_EQ(camera.x, (Vec3{1, 0, 0}));
    const Affine down = look_at({0, 5, 0}, {0, 0, 0});
    EXPECT_NEAR(determinant(down), 1, 1e-5);
    EXPECT_NEAR(down.z.y, 1, 1e-6);
}

TEST(Affine, MovingTurnsRoundItsOwnOrigin) {
    const auto keys = moving(translate({1, 0, 0}), {0, 2, 0}, {0, 1, 0}, pi);
    ASSERT_EQ(keys.size(), 4u);
    EXPECT_NEAR(keys.back().origin.y, 2, 1e-6);
    EXPECT_NEAR(keys.back().origin.x, 1, 1e-6);
    EXPECT_NEAR(keys.back().x.x, -1, 1e-5);
}

}  // namespace
}  // namespace weft
