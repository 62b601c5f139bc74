// OBJ: polygons, normals, smoothing, materials, and what is said of broken files.
#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "render/check_scene.h"
#include "render/polygon.h"
#include "render/scene_file.h"
#include "run_node.h"

namespace weft {
namespace {

std::vector<std::string> warnings;

Scene read(const std::string& text, const std::string& path = "test.obj") {
    warnings.clear();
    Scene scene = obj_scene(text, path, {}, warnings);
    check_scene(scene);
    return scene;
}

double area(std::span<const Vec3> points, const std::vector<std::array<int, 3>>& triangles) {
    double sum = 0;
    for (const auto& t : triangles) {
        const Vec3 a = points[size_t(t[0])];
        sum += 0.5 * cross(points[size_t(t[1])] - a, points[size_t(t[2])] - a).z;
    }
    return sum;
}

TEST(Polygon, ConcaveOnesKeepTheirArea) {
    // An arrow head and a comb: a fan would reach outside them.
    const std::vector<Vec3> arrow = {{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5f, 1, 0}};
    EXPECT_EQ(triangulated(arrow).size(), 2u);
    EXPECT_NEAR(area(arrow, triangulated(arrow)), 1.5, 1e-5);
    const std::vector<Vec3> comb = {{0, 0, 0}, {5, 0, 0}, {5, 3, 0}, {4, 3, 0},
                                    {4, 1, 0}, {3, 1, 0}, {3, 3, 0}, {2, 3, 0},
                                    {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
    const auto triangles = triangulated(comb);
    EXPECT_EQ(triangles.size(), 10u);
    EXPECT_NEAR(area(comb, triangles), 11, 1e-4);
    for (const auto& t : triangles) EXPECT_GE(area(comb, {t}), 0);
}

TEST(Polygon, DamagedOnesEnd) {
    EXPECT_EQ(triangulated(std::vector<Vec3>(7, Vec3{1, 1, 1})).size(), 5u);
    EXPECT_EQ(triangulated(std::vector<Vec3>{{NAN, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}).size(),
              2u);
    EXPECT_TRUE(triangulated(std::vector<Vec3>(2)).empty());
}

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

TEST(Obj, AQuadHasTwoTrianglesAndUprightTexture) {
    const Scene scene = read(square + "f 1/1 2/2 3/3 4/4\n");
    ASSERT_EQ(scene.meshes.size(), 1u);
    const Mesh& mesh = scene.meshes[0];
    EXPECT_EQ(mesh.triangles.size(), 2u);
    EXPECT_EQ(mesh.positions.size(), 4u);
    for (size_t i = 0; i < 4; ++i) EXPECT_EQ(mesh.uv[i].y, 1 - mesh.positions[i].y);  // v runs down
    EXPECT_TRUE(mesh.normals.empty());
}

TEST(Obj, SmoothingGroupsMakeNormals) {
    // A roof: smooth, its ridge looks up; not smooth, each side keeps its own.
    const std::string roof = "v -1 0 0\nv 0 1 0\nv 1 0 0\nv -1 0 -1\nv 0 1 -1\nv 1 0 -1\n";
    const Scene smooth = read(roof + "s 1\nf 1 2 5 4\nf 2 3 6 5\n");
    size_t ridges = 0;
    for (size_t i = 0; i < smooth.meshes[0].positions.size(); ++i)
        if (smooth.meshes[0].positions[i].y == 1) {
            EXPECT_NEAR(std::fabs(smooth.meshes[0].normals[i].y), 1, 1e-5);
            ++ridges;
        }
    EXPECT_EQ(ridges, 2u);
    EXPECT_TRUE(read(roof + "s off\nf 1 2 5 4\nf 2 3 6 5\n").meshes[0].normals.empty());
    const Scene given = read(roof + "vn 0 0 1\ns 1\nf 1//1 2//1 5//1 4//1\n");
    EXPECT_EQ(given.meshes[0].normals[0], (Vec3{0, 0, 1}));
}

// m.mtl, and files in the place of the pictures that it names.
void write_materials(const TestFolder& folder, const std::string& mtl,
                     const std::vector<std::string>& pictures) {
    std::ofstream(folder / "m.mtl") << mtl;
    for (const std::string& name : pictures) std::ofstream(folder / name) << "a picture";
}

TEST(Obj, FacesAreGatheredByMaterial) {
    TestFolder folder;
    write_materials(folder,
                    "newmtl red\nKd 0.8 0.1 0.1\nnewmtl glass\nKd 0 0 0\nKs 1 1 1\nNs 900\nd 0.1\n"
                    "newmtl leaf\nKd 1 1 1\nmap_Kd tree.png\nmap_d mask.png\n"
                    "newmtl lamp\nKd 0 0 0\nKe 5 4 3\n",
                    {"tree.png", "mask.png"});
    const Scene scene =
        read("mtllib m.mtl\n" + square +
                 "g a\nusemtl red\nf 1 2 3\ng b\nusemtl glass\nf 1 3 4\ng c\nusemtl red\nf 2 3 4\n"
                 "usemtl leaf\nf 1/1 2/2 3/3\nusemtl lamp\nf 1 2 4\n",
             folder / "test.obj");
    ASSERT_EQ(scene.meshes.size(), 4u);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 2u);
    EXPECT_EQ(scene.instances[0].name, "red");
    EXPECT_NEAR(scene.materials[0].base_color.x, 0.8, 1e-6);
    EXPECT_EQ(scene.materials[0].kind, Material::Kind::diffuse);
    EXPECT_NEAR(scene.materials[1].transmission, 0.9, 1e-6);
    EXPECT_EQ(scene.materials[2].alpha, Material::Alpha::mask);
    ASSERT_EQ(scene.textures.size(), 2u);
    EXPECT_EQ(scene.textures[0].path, folder / "tree.png");
    EXPECT_FALSE(scene.textures[1].color);
    EXPECT_EQ(scene.materials[3].emission, (Vec3{5, 4, 3}));
}

TEST(Obj, BumpAndNormalMaps) {
    TestFolder folder;
    write_materials(folder,
                    "newmtl a\nmap_Bump -bm 0.5 brick.png\nnewmtl b\nbump brick.png\nnewmtl c\n"
                    "map_bump brick.png\nnorm flat.png\nnewmtl d\nbump -bm 0 brick.png\n"
                    "newmtl e\nbump gone.png\nnewmtl f\nmap_Kd brick.png\nbump -bm 0.5 brick.png\n",
                    {"brick.png", "flat.png"});
    const Scene scene = read("mtllib m.mtl\n" + square + "f 1/1 2/2 3/3\n", folder / "test.obj");
    const auto texture = [&](size_t m) -> const TextureFile& {
        return scene.textures[size_t(scene.materials[m].normal_map.file)];
    };
    EXPECT_EQ(texture(0).path, folder / "brick.png");
    EXPECT_EQ(texture(0).bump, 0.5f);
    EXPECT_FALSE(texture(0).color);
    EXPECT_EQ(texture(1).bump, 1);
    EXPECT_EQ(texture(2).path, folder / "flat.png");  // a normal map says more
    EXPECT_EQ(texture(2).bump, 0);
    EXPECT_FALSE(scene.materials[3].normal_map.used());
    EXPECT_FALSE(scene.materials[4].normal_map.used());
    EXPECT_EQ(warnings[0], folder / "test.obj" + ": material 'e': no picture 'gone.png'; left out");
    EXPECT_EQ(&texture(5), &texture(0));
    EXPECT_EQ(scene.textures.size(), 4u);  // as heights twice, as normals, as colours
}

TEST(Obj, BrokenFilesAreTold) {
    const auto says = [](const std::string& text, const std::string& expected) {
        const std::string found = error_of([&] { read(text); });
        EXPECT_NE(found.find(expected), std::string::npos) << found << "\nexpected: " << expected;
    };
    says("", "nothing to see: it has no faces");
    says("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "face 1: vertex 9 of 3");
    says("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/5 2/5 3/5\n", "face 1: texture coordinate 5 of 0");
    says("v 1e60 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "vertex 1 is not finite");
    std::string many, face = "f";
    for (int i = 1; i <= 300; ++i) {
        many += fmt::format("v {} {} 0\n", std::cos(i * 0.02), std::sin(i * 0.02));
        face += fmt::format(" {}", i);
    }
    says(many + face + "\n", "a face has more than 255 corners");
    read("mtllib gone.mtl\n" + square + "usemtl red\nf 1 2 3\n");
    EXPECT_NE(warnings[0].find("gone.mtl: no such file"), std::string::npos);
    // Names that no file can have.
    const std::string long_name(300, 'x');
    read("mtllib " + long_name + ".mtl\n" + square + "usemtl red\nf 1 2 3\n");
    EXPECT_NE(warnings[0].find("x.mtl: no such file"), std::string::npos);
    TestFolder folder;
    write_materials(folder, "newmtl a\nmap_Kd " + long_name + ".png\n", {});
    read("mtllib m.mtl\n" + square + "usemtl a\nf 1 2 3\n", folder / "test.obj");
    EXPECT_NE(warnings[0].find("material 'a': no picture 'xxx"), std::string::npos);
}

}  // namespace
}  // namespace weft
