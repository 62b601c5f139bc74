// Directional occlusion against what is exact above a plane.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <random>

#include "image/image.h"
#include "render/scene.h"
#include "samples/samples.h"
#include "tests/run_node.h"

namespace weft {
namespace {

constexpr double pi_of = 3.14159265358979323846;

// The ground around the origin, seen from just above it, under some shapes.
Samples rays_under(const std::string& shapes, int spp, int seed = 1, int size = 24) {
    TestFolder folder;
    const std::string file = folder / "scene.json";
    std::ofstream(file) << fmt::format(R"({{"weft_scene": 1,
        "materials": {{"grey": {{"kind": "diffuse", "color": [0.5, 0.5, 0.5]}}}},
        "shapes": [{{"shape": "plane", "material": "grey", "scale": 1000}}, {}],
        "environment": {{"color": [1, 1, 1]}},
        "camera": {{"at": [0, 0.3, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 60}}}})",
                                       shapes);
    const Scene scene = RunNode("read-scene").set("file", file).out<Scene>("scene");
    const Samples samples = RunNode("render-samples")
                                .in("scene", scene)
                                .set("width", size)
                                .set("height", size)
                                .set("spp", spp)
                                .set("mode", "direct")
                                .set("channels", Json::list({"basic", "position", "normal", "id"}))
                                .out<Samples>("samples");
    return RunNode("render-occlusion-rays")
        .in("scene", scene)
        .in("samples", samples)
        .set("seed", seed)
        .out<Samples>("samples");
}
Image occlusion_of(const Samples& samples, const char* port = "image") {
    return RunNode("directional-occlusion").in("samples", samples).out<Image>(port);
}
struct Off {
    double mean, rmse, own;  // of the middle pixels; own: of their own rays alone
};
Off off(const Samples& samples, double exact) {
    const Image shared = occlusion_of(samples);
    const Image own =
        RunNode("directional-occlusion").in("samples", samples).set("reach", 0).out<Image>("image");
    Off out{};
    int n = 0;
    const int middle = samples.width / 2;
    for (int y = middle - 2; y < middle + 2; ++y)
        for (int x = middle - 2; x < middle + 2; ++x, ++n) {
            const double d = double(*shared.at(x, y)) - exact, e = double(*own.at(x, y)) - exact;
            out.mean += d, out.rmse += d * d, out.own += e * e;
        }
    return {out.mean / n, std::sqrt(out.rmse / n), std::sqrt(out.own / n)};
}

std::string sphere(double r, double h) {
    return fmt::format(
        R"({{"shape": "sphere", "material": "grey", "at": [0, {}, 0], "scale": {}}})", h, r);
}
std::string disc(double r, double h) {
    return fmt::format(R"({{"shape": "disc", "material": "grey", "at": [0, {}, 0], "scale": {}}})",
                       h, r);
}
std::string wall(double H, double d) {
    return fmt::format(
        R"({{"shape": "wall", "material": "grey", "at": [0, {}, {}], "scale": [500, {}, 1]}})",
        H / 2, -d, H / 2);
}

struct Above {
    const char* name;
    std::string shapes;
    double exact;
};
std::vector<Above> known() {
    std::vector<Above> all = {
        {"sphere", sphere(1, 2), .25},
        {"disc", disc(1, 1), .5},
        {"wall", wall(1, 1), .14644661},
        {"endless_wall", wall(1000, 1), .5},
    };
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const char* name : {"sphere_1", "sphere_2", "disc_1", "disc_2", "wall_1", "wall_2"}) {
        const double a = .5 + unit(random), b = a + .4 + 2 * unit(random);
        if (name[0] == 's')
            all.push_back({name, sphere(a, b), a * a / (b * b)});
        else if (name[0] == 'd')
            all.push_back({name, disc(a, b), a * a / (a * a + b * b)});
        else
            all.push_back({name, wall(b, a), (1 - a / std::hypot(a, b)) / 2});
    }
    return all;
}
class KnownOcclusion : public testing::TestWithParam<Above> {};

TEST_P(KnownOcclusion, IsFoundFromAFewRays) {
    const Off found = off(rays_under(GetParam().shapes, 8), GetParam().exact);
    EXPECT_LT(found.rmse, .03) << "mean " << found.mean << ", own rays " << found.own;
    // Eight rays may happen to be right by half of them.
    EXPECT_LT(found.rmse, std::max(found.own, .01));
    RecordProperty("shared", std::to_string(found.rmse));
    RecordProperty("own", std::to_string(found.own));
}
INSTANTIATE_TEST_SUITE_P(Above, KnownOcclusion, testing::ValuesIn(known()),
                         [](const auto& of) { return std::string(of.param.name); });

TEST(DirectionalOcclusion, of_nothing_is_none_and_its_harmonics_are_those_of_the_cosine) {
    const Samples samples =
        rays_under(R"({"shape": "disc", "material": "grey", "at": [0, -5, 0]})", 16);
    const Image open = occlusion_of(samples);
    for (const float o : open.pixels()) EXPECT_EQ(o, 0.0f);
    const Image basis = RunNode("directional-occlusion")
                            .in("samples", samples)
                            .set("output", "harmonics")
                            .out<Image>("image");
    double mean[9] = {};
    for (int y = 0; y < basis.height(); ++y)
        for (int x = 0; x < basis.width(); ++x)
            for (int c = 0; c < 9; ++c)
                mean[c] += double(basis.at(x, y)[c]) / (basis.width() * basis.height());
    // Integrals of the cosine about +y times the harmonics: pi Y00, 2 pi / 3 Y1 ..., pi / 4 Y2.
    EXPECT_NEAR(mean[0], .886227, 1e-3);
    EXPECT_NEAR(mean[1], 1.023327, 5e-3);
    EXPECT_NEAR(mean[2], 0, 5e-3);
    EXPECT_NEAR(mean[8], -.429043, 5e-3);  // x^2 - y^2
    EXPECT_NEAR(mean[6], -.247708, 5e-3);  // 3 z^2 - 1
}

// Beside a wall that touches the ground: exact also where it is nearer than a few pixels.
TEST(DirectionalOcclusion, is_right_up_to_where_something_touches) {
    const Samples samples = rays_under(wall(1, 0.1), 8);
    const Image shared = occlusion_of(samples);
    const Image own =
        RunNode("directional-occlusion").in("samples", samples).set("reach", 0).out<Image>("image");
    const double half = 0.3 * std::tan(pi_of / 6);  // of the ground that is seen
    double after = 0, before = 0;
    int n = 0;
    for (int y = 0; y < shared.height(); ++y)
        for (int x = 0; x < shared.width(); ++x) {
            const double z = ((y + .5) / shared.height() * 2 - 1) * half, d = z + 0.1;
            if (d < .01) continue;
            const double exact = (1 - d / std::hypot(d, 1)) / 2;
            after += std::pow(double(*shared.at(x, y)) - exact, 2);
            before += std::pow(double(*own.at(x, y)) - exact, 2), ++n;
        }
    EXPECT_GT(n, 300);
    EXPECT_LT(std::sqrt(after / n), .035) << "own rays " << std::sqrt(before / n);
    EXPECT_LT(after, .35 * before);
}

TEST(DirectionalOcclusion, says_what_it_needs) {
    Samples samples;
    samples.width = samples.height = samples.spp = 1;
    samples.set_size(1);
    samples.add("xy", 2, {.5f, .5f});
    EXPECT_NE(error_of([&] { occlusion_of(samples); }).find("needs z, position"),
              std::string::npos);
}

}  // namespace
}  // namespace weft
