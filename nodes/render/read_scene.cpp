// read-scene: a scene from a file: glTF 2.0, Wavefront OBJ, the JSON scene form, or one of the
// procedural scenes by name.
#include "render/scene_file.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct ReadScene {
    std::string file;
    std::string camera, animation;
    float shutter_open = 0, shutter_close = 1.0f / 48;
    std::uint64_t seed = 1;
    float size = 1;

    static void declare(Ports<ReadScene>& node) {
        node.about(
                "reads a scene: glTF 2.0, OBJ, the JSON scene form, or procedural:NAME. "
                "docs/scenes.md tells what is read of each and how it is taken; what is left out "
                "is warned of")
            .out<Scene>("scene", "meshes, materials, lights and a camera")
            .param("file", &ReadScene::file,
                   {.about = "a .gltf, .glb, .obj or .json scene file, or procedural:leaves, "
                             "procedural:chess, procedural:motion, procedural:occluders, "
                             "procedural:cornell",
                    .required = true})
            .param("camera", &ReadScene::camera,
                   {.about = "which of the file's cameras, by name or number; empty: the first"})
            .param("animation", &ReadScene::animation,
                   {.about = "glTF: the animation to play, by name or number; empty: all"})
            .param("shutter-open", &ReadScene::shutter_open,
                   {.unit = "s", .min = -1e6, .max = 1e6, .about = "glTF: when the shutter opens"})
            .param("shutter-close", &ReadScene::shutter_close,
                   {.unit = "s", .min = -1e6, .max = 1e6, .about = "glTF: when the shutter closes"})
            .param("seed", &ReadScene::seed,
                   {.about = "procedural: another arrangement of the scene"})
            .param("size", &ReadScene::size,
                   {.min = 0.01,
                    .max = 1000,
                    .about = "procedural: how much there is in it; the number of things grows with "
                             "it"});
    }

    std::vector<std::string> reads() const { return scene_files(file); }

    void run(const Inputs&, Outputs& out, Context& ctx) const {
        if (shutter_close < shutter_open)
            ctx.fail("the shutter closes before it opens: shutter-close is less than shutter-open");
        std::vector<std::string> warnings;
        const SceneOptions options{camera, animation, shutter_open, shutter_close, seed, size};
        out.set("scene", read_scene_file(file, options, warnings));
        constexpr size_t most = 8;
        for (size_t i = 0; i < std::min(warnings.size(), most); ++i) ctx.warn(warnings[i]);
        if (warnings.size() > most)
            ctx.warn(std::to_string(warnings.size() - most) + " more findings of this kind");
    }
};

WEFT_NODE(ReadScene, "read-scene", 3);

}  // namespace
}  // namespace weft
