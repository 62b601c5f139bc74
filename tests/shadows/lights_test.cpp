// Several lights at once, each with a light field of its own.
#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "tests/graph_run.h"

namespace weft {
namespace {

const std::string graphs = std::string(WEFT_SOURCE_DIR) + "/graphs/";

double rmse(const Image& a, const Image& b) {
    double sum = 0;
    for (size_t i = 0; i < a.pixels().size(); ++i)
        sum += std::pow(double(a.pixels()[i] - b.pixels()[i]), 2);
    return std::sqrt(sum / double(a.pixels().size()));
}

// The shipped graph on the shipped scene, with the shadows of these lights.
Image shadows_of(const std::string& lights, int threads = 1, int tile = 32) {
    std::stringstream text;
    text << std::ifstream(graphs + "soft-shadows-lights.json").rdbuf();
    return GraphRun(text.str(), tile, threads, true,
                    {"scene=" + graphs + "scenes/shadow-two-lights.json", "lights=" + lights,
                     "width=120", "height=68", "spp=9", "locations=32", "out=OUT"})
        .picture;
}
// The mean of so many samples.
Image mean_of(int spp) {
    return GraphRun(fmt::format(R"({{"weft": 1, "nodes": {{
        "scene":   {{"type": "read-scene", "set": {{"file": "{}scenes/shadow-two-lights.json"}}}},
        "render":  {{"type": "render-samples", "in": {{"scene": "scene"}}, "set": {{"width": 120, "height": 68, "spp": {}}}}},
        "picture": {{"type": "pixel-filter", "in": {{"samples": "render"}}}},
        "write":   {{"type": "write-image", "in": {{"image": "picture"}}, "set": {{"file": "OUT", "depth": "float"}}}}}}}})",
                                graphs, spp))
        .picture;
}

TEST(SeveralLights, AreNearerToTheTruthTogetherThanEachAlone) {
    const Image truth = mean_of(512), both = shadows_of(R"(["wide", "narrow"])");
    const double error = rmse(both, truth), input = rmse(mean_of(9), truth);
    EXPECT_LT(error, 0.45 * input);
    EXPECT_LT(error, rmse(shadows_of(R"(["wide"])"), truth));
    EXPECT_LT(error, rmse(shadows_of(R"(["narrow"])"), truth));
    // In whatever order, and the same bits for any threads and tiles.
    EXPECT_LT(rmse(shadows_of(R"(["narrow", "wide"])"), truth), 0.45 * input);
    EXPECT_EQ(values_of(shadows_of(R"(["wide", "narrow"])", 3, 17)), values_of(both));
}

}  // namespace
}  // namespace weft
