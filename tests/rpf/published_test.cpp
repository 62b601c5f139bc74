// Preset release against what the program of 2015 measures on real samples: the mean of W_c^r, how
// much of the colour it takes for noise, in each of its four passes.
#include <array>
#include <filesystem>

#include "samples/write_npz.h"
#include "tests/graph_run.h"
#include "tests/rpf/rpf_test.h"

namespace weft {
namespace {

// Pixels [x, x + width) x [y, y + height) of a buffer, as a buffer.
Samples crop(const Samples& from, int x, int y, int width, int height) {
    Samples to;
    to.width = width;
    to.height = height;
    to.spp = from.spp;
    const auto spp = size_t(from.spp);
    to.set_size(size_t(width) * size_t(height) * spp);
    for (const Channel& c : from.channels) {
        const auto k = size_t(c.components);
        std::vector<float> values;
        for (int row = y; row < y + height; ++row) {
            const size_t first = (size_t(row) * size_t(from.width) + size_t(x)) * spp;
            for (size_t i = k * first; i < k * (first + size_t(width) * spp); ++i)
                values.push_back(c.name != "xy" ? c.values[i]
                                                : c.values[i] - float(i % 2 == 0 ? x : y));
        }
        to.add(c.name, c.components, values);
    }
    return to;
}

struct Scene {
    const char* name;
    std::array<double, 4> noise;
};
struct Pass {
    const char *box, *fraction, *sigma, *seed;
};

class ReleaseOnRealSamples : public testing::TestWithParam<Scene> {};

TEST_P(ReleaseOnRealSamples, takes_as_much_for_noise_as_the_program_does) {
    const std::filesystem::path file = std::filesystem::path(WEFT_SOURCE_DIR).parent_path() /
                                       "shared" / "data" / GetParam().name / "s08.npz";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no samples of " << GetParam().name;
    const TestFolder folder;
    PlainContext ctx;
    const Samples whole = RunNode("read-samples")
                              .set("file", Json(file.string()))
                              .set("channels", Json::list({Json("*")}))
                              .out<Samples>("samples");
    write_npz(crop(whole, 100, 45, 120, 90), folder / "samples.npz", false, ctx);
    // As in parts/rpf-release.json.
    const Pass passes[] = {{"45", "0.3333", "0.2444", "1"},
                           {"30", "0.3333", "0.2417", "2"},
                           {"15", "0.5", "0.2333", "3"},
                           {"5", "0.5", "0.2", "4"}};
    for (size_t t = 0; t < std::size(passes); ++t) {
        const Pass& pass = passes[t];
        const GraphRun run(std::string(R"({"weft": 1, "nodes": {
        "samples": {"type": "read-samples", "set": {"channels": ["*"], "file": ")") +
                               (folder / "samples.npz") + R"("}},
        "clamped": {"type": "clamp-radiance", "in": {"samples": "samples"}, "set": {"most": 10}},
        "vectors": {"type": "build-vectors", "in": {"samples": "clamped"},
                    "set": {"random": ["uv", "t", "light_uv"], "pixels": false}},
        "around":  {"type": "neighbourhoods", "in": {"vectors": "vectors"},
                    "set": {"draw": "distinct", "cluster-on": "first-hit", "position-sigma": 50, "box": )" +
                               pass.box + R"(, "fraction": )" + pass.fraction + R"(, "sigma": )" +
                               pass.sigma + R"(, "seed": )" + pass.seed + R"(}},
        "weights": {"type": "dependency-estimate", "in": {"neighbourhoods": "around"},
                    "set": {"binning": "spanned", "correction": "none"}},
        "map":     {"type": "show-dependence", "in": {"neighbourhoods": "around", "weights": "weights"}},
        "write":   {"type": "write-image", "in": {"image": "map"}, "set": {"file": "OUT", "depth": "float"}}}})",
                           32, 2);
        double sum = 0;
        for (const float w : run.picture.pixels()) sum += double(w);
        EXPECT_NEAR(sum / double(run.picture.pixels().size()), GetParam().noise[t], 0.015)
            << "pass " << t;
    }
}
// As published, to two digits: within 0.01 and half a digit.
INSTANTIATE_TEST_SUITE_P(Scenes, ReleaseOnRealSamples,
                         testing::Values(Scene{"buddhas", {0.38, 0.47, 0.60, 0.72}},
                                         Scene{"bmw", {0.71, 0.72, 0.74, 0.72}}),
                         [](const auto& scene) { return std::string(scene.param.name); });

}  // namespace
}  // namespace weft
