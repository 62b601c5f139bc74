// Procedural scenes: sound, the same for a seed, of the size asked for, of what they promise.
#include "render/procedural_scene.h"

#include "render/check_scene.h"
#include "run_node.h"

namespace weft {
namespace {

TEST(ProceduralScene, AllAreSoundAtEverySize) {
    for (const std::string& name : procedural_scene_names())
        for (const float size : {0.01f, 0.3f, 1.0f, 4.0f})
            for (const std::uint64_t seed : {1u, 2u}) {
                const Scene scene = procedural_scene(name, seed, size);
                EXPECT_EQ(error_of([&] { check_scene(scene); }), "") << name << " " << size;
                EXPECT_GT(scene.placed_triangles(), 10u) << name;
                EXPECT_TRUE(!scene.lights.empty() || scene.environment.present()) << name;
            }
}

TEST(ProceduralScene, TheSeedDecides) {
    const auto places = [](std::uint64_t seed) {
        std::vector<Affine> all;
        for (const Instance& i : procedural_scene("leaves", seed, 0.2f).instances)
            all.push_back(i.to_world.front());
        return all;
    };
    EXPECT_EQ(places(3), places(3));
    EXPECT_NE(places(3), places(4));
}

TEST(ProceduralScene, SizeMultipliesThings) {
    const Scene one = procedural_scene("leaves", 1, 1), ten = procedural_scene("leaves", 1, 10);
    EXPECT_GT(ten.instances.size(), 8 * one.instances.size());
    EXPECT_LT(ten.triangles(), 10 * one.triangles());  // instances, not copies
}

TEST(ProceduralScene, HasWhatItIsFor) {
    const auto moving = [](const Scene& scene) {
        size_t count = 0;
        for (const Instance& i : scene.instances) count += i.to_world.size() > 1;
        return count;
    };
    EXPECT_GT(moving(procedural_scene("leaves")), 500u);
    EXPECT_GT(moving(procedural_scene("motion")), 30u);
    EXPECT_GT(procedural_scene("chess").camera.lens_radius, 0);
    EXPECT_EQ(procedural_scene("occluders").lights.size(), 1u);
    const Scene cornell = procedural_scene("cornell");
    using Kind = Material::Kind;
    for (const Kind kind : {Kind::diffuse, Kind::conductor, Kind::dielectric}) {
        bool found = false;
        for (const Material& m : cornell.materials) found |= m.kind == kind;
        EXPECT_TRUE(found);
    }
}

TEST(ProceduralScene, AnUnknownNameIsTold) {
    EXPECT_EQ(error_of([] { procedural_scene("ches"); }),
              "procedural:ches: no such scene; did you mean 'chess'?");
}

TEST(ProceduralScene, IsANode) {
    const Scene scene = RunNode("procedural-scene").set("name", "cornell").out<Scene>("scene");
    EXPECT_EQ(scene.name, "cornell");
    EXPECT_EQ(scene.source, "procedural:cornell, seed 1, size 1");
}

}  // namespace
}  // namespace weft
