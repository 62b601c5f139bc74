// procedural-scene: scenes made by rule, which need no file.
#include "render/procedural_scene.h"

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "graph/error.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct Entry {
    const char* name;
    Scene (*make)(std::uint64_t seed, float size);
};
constexpr Entry entries[] = {{"leaves", leaves_scene},
                             {"chess", chess_scene},
                             {"motion", motion_scene},
                             {"occluders", occluders_scene},
                             {"cornell", cornell_scene}};

}  // namespace

const std::vector<std::string>& procedural_scene_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const Entry& entry : entries) all.emplace_back(entry.name);
        return all;
    }();
    return names;
}

Scene procedural_scene(std::string_view name, std::uint64_t seed, float size) {
    for (const Entry& entry : entries)
        if (name == entry.name) {
            Scene scene = entry.make(seed, size);
            scene.name = name;
            scene.source = fmt::format("procedural:{}, seed {}, size {}", name, seed, size);
            return scene;
        }
    throw Error(fmt::format("procedural:{}: no such scene{}", name,
                            suggestion(name, procedural_scene_names())));
}

namespace {

struct ProceduralScene {
    enum class Name { leaves, chess, motion, occluders, cornell } name = Name::leaves;
    std::uint64_t seed = 1;
    float size = 1;

    static void declare(Ports<ProceduralScene>& node) {
        node.about("a scene made by rule, which needs no file: with lens, shutter and lights")
            .out<Scene>("scene", "meshes, materials, lights and a camera")
            .choice("name", &ProceduralScene::name, procedural_scene_names(),
                    {.about = "leaves: leaves and butterflies over depth; chess: a deep, defocused "
                              "board; motion: fast and spinning things; occluders: soft shadows of "
                              "a tree; cornell: a box for path tracing"})
            .param("seed", &ProceduralScene::seed, {.about = "another arrangement of the scene"})
            .param("size", &ProceduralScene::size,
                   {.min = 0.01,
                    .max = 1000,
                    .about = "how much there is in it; the number of things grows with it"});
    }

    void run(const Inputs&, Outputs& out, Context&) const {
        out.set("scene", procedural_scene(procedural_scene_names()[size_t(name)], seed, size));
    }
};

WEFT_NODE(ProceduralScene, "procedural-scene", 1);

}  // namespace
}  // namespace weft
