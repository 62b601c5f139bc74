// How dense the camera's samples are on a light's film, by their neighbours there.
#include <fstream>
#include <random>

#include "render/scene.h"
#include "shadows/film_points.h"
#include "shadows/light_view.h"
#include "tests/run_node.h"

namespace weft {
namespace {

using shadows::FilmPoints;

std::vector<FilmPoints::Point> random_points(size_t n, float side, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> place(0, side);
    std::vector<FilmPoints::Point> out(n);
    for (auto& p : out) p = {place(random), place(random)};
    return out;
}

TEST(FilmPoints, FindTheDistanceThatALookAtAllOfThemFinds) {
    for (const size_t n : {1u, 2u, 9u, 500u}) {
        std::vector<FilmPoints::Point> all = random_points(n, 10, unsigned(n));
        // Some lie in one place, or on one line.
        for (size_t i = 0; i < n / 4; ++i) all[i] = all[n / 2];
        for (size_t i = n / 4; i < n / 3; ++i) all[i][0] = all[n / 2][0];
        const FilmPoints points(all);
        for (const FilmPoints::Point at : random_points(50, 12, 3))
            for (const size_t k : {size_t(1), n / 3 + 1, n}) {
                std::vector<float> squares, nearest(k);
                for (const FilmPoints::Point p : all) {
                    const float dx = p[0] - at[0], dy = p[1] - at[1];
                    squares.push_back(dx * dx + dy * dy);
                }
                std::sort(squares.begin(), squares.end());
                EXPECT_EQ(points.distance(at, nearest), std::sqrt(squares[k - 1])) << n << " " << k;
            }
    }
}

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
    const auto metric = near.values("light_metric");
    for (size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(metric[3 * i], a[i]);
        EXPECT_EQ(metric[3 * i + 1], 0);
        EXPECT_EQ(metric[3 * i + 2], a[i]);
    }
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

}  // namespace
}  // namespace weft
