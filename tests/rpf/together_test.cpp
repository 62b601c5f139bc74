// graphs/rpf-tlfr.json as it is shipped: nearer to the truth than either method alone, on scenes
// with lens, motion and noise.
#include <fstream>
#include <sstream>

#include "image/measures.h"
#include "tests/graph_run.h"
#include "tests/rpf/rpf_test.h"

namespace weft {
namespace {

constexpr const char* size = R"("width": 96, "height": 54)";

Image render(const std::string& scene, int spp, int seed, const std::string& samples) {
    const GraphRun run(R"({"weft": 1, "nodes": {
        "scene": {"type": "read-scene", "set": {"file": ")" +
                           scene + R"("}},
        "samples": {"type": "render-samples", "in": {"scene": "scene"}, "set": {)" +
                           size + R"(, "spp": )" + std::to_string(spp) + R"(, "seed": )" +
                           std::to_string(seed) + R"(}},
        "keep": {"type": "write-samples", "in": {"samples": "samples"}, "set": {"file": ")" +
                           samples + R"("}},
        "picture": {"type": "pixel-filter", "in": {"samples": "samples"}},
        "write": {"type": "write-image", "in": {"image": "picture"}, "set": {"file": "OUT", "depth": "float"}}}})",
                       32, 2);
    return run.picture;
}
Image reconstruct(const std::string& graph, const std::string& samples) {
    std::stringstream text;
    text << std::ifstream(std::string(WEFT_SOURCE_DIR) + "/graphs/" + graph + ".json").rdbuf();
    const GraphRun run(text.str(), 32, 2, true, {"samples=" + samples, "out=OUT"});
    return run.picture;
}

class Together : public testing::TestWithParam<const char*> {};

TEST_P(Together, is_nearer_to_the_reference_than_each_alone) {
    const TestFolder folder;
    const std::string name = GetParam(), scene = name.starts_with("procedural:")
                                                     ? name
                                                     : WEFT_SOURCE_DIR "/graphs/scenes/" + name;
    const Image reference = render(scene, 256, 11, folder / "many.npz");
    render(scene, 8, 7, folder / "few.npz");
    PlainContext ctx;
    const auto error = [&](const std::string& graph) {
        return compare_pictures(reconstruct(graph, folder / "few.npz"), reference, ctx)
            .measures.rel_mse;
    };
    EXPECT_LT(error("rpf-tlfr"), std::min(error("rpf"), error("tlfr")));
}
INSTANTIATE_TEST_SUITE_P(Scenes, Together,
                         testing::Values("pan.json", "shadow-flight.json", "procedural:chess"),
                         [](const auto& scene) {
                             std::string name;
                             for (const char c : std::string(scene.param))
                                 name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                             return name;
                         });

}  // namespace
}  // namespace weft
