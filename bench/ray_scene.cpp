// How long until a scene's rays can be traced?
//   bench_ray_scene [SCENE[:SIZE]...] [--repeat N]
// Built-in scenes (by default leaves:25, tens of thousands of leaves that turn as they fall, and leaves and
// motion as they are), made ready on one thread: CPU seconds, median and range of --repeat runs, and what
// they come to for each thing placed.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "bench/cpu_time.h"
#include "render/procedural_scene.h"
#include "render/ray_scene.h"

namespace {

using namespace weft;
using namespace weft::render;

void measure(const std::string& what, int repeat) {
    const size_t colon = what.find(':');
    const float size = colon == std::string::npos ? 1 : std::strtof(what.c_str() + colon + 1, nullptr);
    const Scene scene = procedural_scene(what.substr(0, colon), 1, size);
    PlainContext ctx;
    std::vector<double> took;
    size_t objects = 0, moving = 0, keys = 0;
    for (int r = 0; r < repeat; ++r) {
        const double start = cpu_s();
        const RayScene rays(scene, ctx);
        took.push_back(cpu_s() - start);
        objects = rays.objects().size(), moving = keys = 0;
        for (const Object& object : rays.objects())
            if (object.placement.moving()) ++moving, keys += object.placement.matrices().size();
    }
    std::sort(took.begin(), took.end());
    fmt::print("{:<12} {:7} placed, {:6} move by {:4.1f} keys: {:7.3f} s ({:.3f} to {:.3f}), {:5.1f} us each\n", what,
               objects, moving, moving ? double(keys) / double(moving) : 0.0, took[took.size() / 2], took.front(),
               took.back(), 1e6 * took[took.size() / 2] / double(std::max<size_t>(objects, 1)));
}

}  // namespace

int main(int argc, char** argv) try {
    std::vector<std::string> scenes;
    int repeat = 5;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        if (key == "--repeat" && i + 1 < argc) repeat = std::max(1, std::atoi(argv[++i]));
        else if (key.starts_with("--")) return fmt::print(stderr, "unknown option {}\n", key), 2;
        else scenes.push_back(key);
    }
    if (scenes.empty()) scenes = {"leaves:25", "leaves", "motion"};
    const FlushDenormals flush;
    for (const std::string& scene : scenes) measure(scene, repeat);
} catch (const std::exception& e) {
    fmt::print(stderr, "bench_ray_scene: {}\n", e.what());
    return 1;
}
