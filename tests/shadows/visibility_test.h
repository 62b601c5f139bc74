// What tests of filters of visibility share: a scene whose shadow is known exactly, rendered, with
// the shadow rays of its light. The light hangs at y = 10 and shines down on the ground, y = 0; the
// camera looks down from below the occluders, so that it sees nothing but the ground.
#pragma once
#include <fmt/format.h>

#include <fstream>
#include <functional>

#include "image/image.h"
#include "render/scene.h"
#include "shadows/light_view.h"
#include "tests/run_node.h"

namespace weft {

struct KnownShadow {
    std::string light = "quad";  // quad [-1, 1]^2 or disc of radius 1
    std::string occluder;        // JSON of shapes
    int spp = 16, width = 64, height = 8;
    double half_width = 1.5;  // of the ground that is seen
    int seed = 1;

    std::string scene() const {
        const std::string size = light == "quad" ? R"("size": [2, 2])" : R"("radius": 1)";
        return fmt::format(R"({{"weft_scene": 1, "shutter": {{"open": 0, "close": 1}},
            "materials": {{"grey": {{"kind": "diffuse", "color": [0.5, 0.5, 0.5]}}}},
            "shapes": [{{"shape": "plane", "material": "grey", "scale": 50}}{}{}],
            "lights": [{{"shape": "{}", "name": "key", "at": [0, 10, 0], "target": [0, 0, 0], "up": [0, 0, -1], {}, "radiance": [1, 1, 1]}}],
            "camera": {{"at": [0, 3, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": {}}}}})",
                           occluder.empty() ? "" : ", ", occluder, light, size,
                           2 * std::atan(half_width / 3 * height / width) * 180 / 3.14159265358979);
    }
};

// A shape at height 4, 6 from the light: a half-plane that ends at x = edge.
inline std::string half_plane(double edge, double speed = 0) {
    return fmt::format(
        R"({{"shape": "plane", "material": "grey", "at": [{}, 4, 0], "scale": [40, 1, 40], "velocity": [{}, 0, 0]}})",
        edge - 40, speed);
}

// The row of values of these nodes as a filter of visibility is given them.
struct SeenShadow {
    Scene scene;
    Samples samples, rays;
    LightView view;
    explicit SeenShadow(const KnownShadow& known) : SeenShadow(known.scene(), known) {}
    // Of another scene, as many pixels and samples as `known` has.
    SeenShadow(const std::string& text, const KnownShadow& known) {
        TestFolder folder;
        const std::string file = folder / "scene.json";
        std::ofstream(file) << text;
        scene = RunNode("read-scene").set("file", file).out<Scene>("scene");
        samples = RunNode("render-samples")
                      .in("scene", scene)
                      .set("width", known.width)
                      .set("height", known.height)
                      .set("spp", known.spp)
                      .set("seed", known.seed)
                      .set("mode", "direct")
                      .set("channels", Json::list({"basic", "position", "normal", "id"}))
                      .out<Samples>("samples");
        view = RunNode("fit-light-view").in("samples", samples).out<LightView>("light-view");
        rays = RunNode("render-light-samples")
                   .in("scene", scene)
                   .in("samples", samples)
                   .in("light-view", view)
                   .set("seed", known.seed)
                   .out<Samples>("light-samples");
    }
    Image bounds(const std::string& port) const {
        return RunNode("occluder-bounds")
            .in("samples", samples)
            .in("light-view", view)
            .in("light-samples", rays)
            .out<Image>(port);
    }
};

// Where pixel column x looks at, on the ground.
inline double ground_x(const KnownShadow& known, int x) {
    return ((x + 0.5) / known.width * 2 - 1) * known.half_width;
}

// Root mean square of visibility against what is exact at a place (x, z) of the ground, where that
// is neither 0 nor 1; and the mean error.
struct VisibilityError {
    double rmse = 0, bias = 0;
    int pixels = 0;
};
inline VisibilityError error_of(const Image& visibility, const KnownShadow& known,
                                const std::function<double(double x, double z)>& exact) {
    VisibilityError e;
    for (int y = 0; y < visibility.height(); ++y)
        for (int x = 0; x < visibility.width(); ++x) {
            const double side = 2 * known.half_width / known.width;
            const double at = exact(ground_x(known, x), (y + 0.5 - 0.5 * known.height) * side);
            if (at <= 0 || at >= 1) continue;
            const double d = double(*visibility.at(x, y)) - at;
            e.rmse += d * d, e.bias += d, ++e.pixels;
        }
    e.rmse = std::sqrt(e.rmse / e.pixels), e.bias /= e.pixels;
    return e;
}

}  // namespace weft
