// How dense the camera's samples are on a light's film, by their neighbours there.
#include <fstream>
#include <random>
#include <sstream>

#include "render/scene.h"
#include "shadows/light_jacobian_kernel.h"
#include "shadows/receivers.h"
#include "tests/graph_run.h"

namespace weft {
namespace {

// A floor under a light, seen from above.
struct Floor {
    Samples samples;
    LightView view;
    explicit Floor(const char* shapes = "", int width = 64) {
        TestFolder folder;
        const std::string file = folder / "scene.json";
        std::ofstream(file) << R"({"weft_scene": 1,
            "materials": {"grey": {"kind": "diffuse", "color": [0.6, 0.6, 0.6]}},
            "shapes": [{"shape": "plane", "material": "grey", "scale": 10})"
                            << shapes << R"(],
            "lights": [{"shape": "quad", "name": "key", "at": [1, 4, 0], "target": [0, 0, 0], "size": [1, 1], "radiance": [20, 20, 20]}],
            "camera": {"at": [0, 3, 6], "target": [0, 0.3, 0], "fov": 28}})";
        samples = RunNode("render-samples")
                      .in("scene", RunNode("read-scene").set("file", file).out<Scene>("scene"))
                      .set("width", width)
                      .set("height", width)
                      .set("spp", 4)
                      .set("channels", Json::list({"basic", "geometric_normal"}))
                      .out<Samples>("samples");
        view = RunNode("fit-light-view").in("samples", samples).out<LightView>("light-view");
    }
    Samples density(const char* node) const {
        return RunNode(node).in("samples", samples).in("light-view", view).out<Samples>("samples");
    }
};

// On a plane neighbours are as far apart as the camera's pixels are large.
TEST(LightDensityNeighbours, AgreeWithTheJacobianOnAPlane) {
    const Floor floor;
    const Samples near = floor.density("light-density-neighbours"),
                  exact = floor.density("light-jacobian");
    const auto a = near.values("light_density"), b = exact.values("light_density");
    double sum = 0, square = 0;
    size_t n = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        // At the picture's rim neighbours are on one side only.
        const float x = floor.samples.xy()[2 * i], y = floor.samples.xy()[2 * i + 1];
        if (x < 4 || y < 4 || x > 60 || y > 60) continue;
        const double d = std::log(double(a[i]) / double(b[i]));
        sum += d, square += d * d, ++n;
    }
    EXPECT_NEAR(sum / double(n), 0, 0.1);
    EXPECT_LT(std::sqrt(square / double(n)), 0.3);
}

// No normals, one sample, none: an answer. No depth: what is missing.
TEST(LightDensityNeighbours, TakeWhatThereIs) {
    const Floor floor("", 16);
    Samples bare = floor.samples;
    std::erase_if(bare.channels, [](const Channel& c) { return c.name == "geometric_normal"; });
    const auto density = [&](const Samples& samples) {
        return RunNode("light-density-neighbours")
            .in("samples", samples)
            .in("light-view", floor.view)
            .out<Samples>("samples");
    };
    EXPECT_EQ(density(bare).values("light_density").size(), bare.size());
    for (const size_t hits : {0u, 1u, 5u}) {
        Samples few = bare;
        std::vector<float> z(bare.z().begin(), bare.z().end());
        std::fill(z.begin() + std::ptrdiff_t(hits), z.end(), INFINITY);
        few.add("z", 1, std::move(z));
        const Samples made = density(few);
        for (const float d : made.values("light_density")) {
            EXPECT_GE(d, 1 / 256.0f);
            EXPECT_LE(d, 256.0f);
        }
    }
    std::erase_if(bare.channels, [](const Channel& c) { return c.name == "z"; });
    try {
        density(bare);
        FAIL() << "samples without depth";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("'light-density-neighbours' needs z"),
                  std::string::npos);
    }
}

// Directions of the camera's picture are equally far in the metric, wherever J takes them.
TEST(FilmMetric, MakesEllipsesOfPixelsRound) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int i = 0; i < 200; ++i) {
        const shadows::Jacobian j{{{number(random), number(random)}, {number(random), number(random)}}};
        const auto jj = shadows::metric_of(j);
        const std::array<float, 3> metric{float(jj[0]), float(jj[1]), float(jj[2])};
        const double det = shadows::area_of(j);
        if (det < 0.05) continue;
        const FilmMetric wide = shadows::film_metric(metric.data(), 1e6f);
        EXPECT_NEAR(double(wide.xx) * double(wide.yy) - double(wide.xy) * double(wide.xy), 1, 1e-3);
        for (int k = 0; k < 12; ++k) {
            const double x = std::cos(0.5 * k), y = std::sin(0.5 * k);
            EXPECT_NEAR(double(wide.square(float(j[0][0] * x + j[0][1] * y),
                                           float(j[1][0] * x + j[1][1] * y))),
                        det, 2e-3 * det + 1e-4);
        }
        // Squares of lengths of one lie between 1 / most and most.
        const FilmMetric narrow = shadows::film_metric(metric.data(), 4);
        for (int k = 0; k < 12; ++k) {
            const float square = narrow.square(float(std::cos(0.5 * k)), float(std::sin(0.5 * k)));
            EXPECT_LE(square, 4.001f);
            EXPECT_GE(square, 0.249f);
        }
    }
    const float round[] = {2, 0, 2}, line[] = {1, 0, 0};
    EXPECT_EQ(shadows::film_metric(round, 16).square(3, 4), 25);
    EXPECT_NEAR(shadows::film_metric(line, 16).square(4, 0), 1, 1e-4f);
}

// Where all pixels are round, ellipses are discs; where J J^T is not there, that is said.
TEST(FilmMetric, IsThatOfPixelsWhereTheseAreRound) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << R"({"weft_scene": 1,
        "materials": {"grey": {"kind": "diffuse", "color": [0.6, 0.6, 0.6]}},
        "shapes": [{"shape": "plane", "material": "grey", "scale": 10},
                   {"shape": "torus", "material": "grey", "at": [0, 1, 0], "scale": 0.6}],
        "lights": [{"shape": "quad", "name": "key", "at": [1, 4, 0], "target": [0, 0, 0], "size": [1, 1], "radiance": [20, 20, 20]}],
        "camera": {"at": [0, 3, 6], "target": [0, 0.3, 0], "fov": 28}})";
    std::stringstream text;
    text << std::ifstream(std::string(WEFT_SOURCE_DIR) + "/graphs/soft-shadows-light-field.json").rdbuf();
    const auto picture = [&](std::vector<std::string> more) {
        std::vector<std::string> set{"scene=" + file, "width=48", "height=30", "locations=16", "out=OUT",
                                     "shadow.search=2"};
        set.insert(set.end(), more.begin(), more.end());
        return values_of(GraphRun(text.str(), 32, 1, true, std::move(set)).picture);
    };
    const std::vector<float> round = picture({});
    EXPECT_EQ(picture({"shadow.metric=ellipse", "density.metric=true", "shadow/receivers.max-anisotropy=1"}),
              round);
    const std::vector<float> ellipse = picture({"shadow.metric=ellipse", "density.metric=true"});
    EXPECT_NE(ellipse, round);
    double difference = 0, sum = 0;
    for (size_t i = 0; i < round.size(); ++i)
        difference += std::abs(double(ellipse[i]) - double(round[i])), sum += double(round[i]);
    EXPECT_LT(difference, 0.03 * sum);

    LoadOptions load;
    const std::string graph = std::string(WEFT_SOURCE_DIR) + "/graphs/soft-shadows-light-field.json";
    load.overrides.set = {"scene=" + file, "width=16", "height=10", "locations=4", "out=" + (folder / "a.exr"),
                          "shadow.metric=ellipse"};
    const Loaded loaded = load_graph(graph, Registry::instance(), load);
    ASSERT_TRUE(loaded.ok());
    Monitor monitor;
    const RunResult result = run_plan(make_plan(loaded.graph), *make_serial_executor(), monitor);
    ASSERT_FALSE(result.errors.empty());
    EXPECT_NE(result.errors[0].message.find("have no light_metric"), std::string::npos)
        << result.errors[0].message;
}

}  // namespace
}  // namespace weft
