// How many texture lookups a second does one thread make? (bench_texture_system: OpenImageIO's
// own.) Input: noise, 2048 x 2048, 8 bit sRGB; batches of 256 lookups; a cache that holds all of
// it, and one that holds a tenth. Prints the median of 5 runs in million lookups a CPU second.
#include <fmt/format.h>

#include <algorithm>

#include "bench/cpu_time.h"
#include "image/png_file.h"
#include "render/textures.h"
#include "samples/random.h"

using namespace weft;

namespace {

constexpr size_t count = 1 << 20, batch = 256;

double rate(const Textures& textures, const std::vector<Vec2>& uv, float width) {
    std::vector<float> widths(count, width), random(count), rgba(4 * batch);
    for (size_t i = 0; i < count; ++i) random[i] = unit_float(mix(i + 77));
    std::vector<double> runs;
    for (int run = 0; run < 5; ++run) {
        const double start = cpu_s();
        for (size_t i = 0; i < count; i += batch)
            textures.lookup(0, TextureMap::Wrap::repeat, TextureMap::Wrap::repeat, {&uv[i], batch},
                            {&widths[i], batch}, {&random[i], batch}, rgba);
        runs.push_back(cpu_s() - start);
    }
    std::sort(runs.begin(), runs.end());
    return double(count) / runs[2] * 1e-6;
}

}  // namespace

int main() {
    Image noise(2048, 2048, 3);
    for (size_t i = 0; i < noise.pixels().size(); ++i) noise.pixels()[i] = unit_float(mix(i));
    std::vector<std::string> warnings;
    Scene scene;
    scene.textures.push_back(
        {"noise.png", std::make_shared<const std::string>(encode_png(noise, {}, warnings))});
    scene.materials.emplace_back();
    scene.materials[0].base_color_map.file = 0;

    std::vector<Vec2> near(count), far(count);
    for (size_t i = 0; i < count; ++i) {
        // Near: the pixels of a picture, row by row. Far: anywhere.
        near[i] = {float(i % 1024) / 1024, float(i / 1024) / 1024};
        far[i] = {unit_float(mix(2 * i)), unit_float(mix(2 * i + 1))};
    }
    for (const size_t megabytes : {256, 4}) {
        const auto textures = open_textures(scene, megabytes << 20);
        rate(*textures, near, 0);
        fmt::print(
            "cache {:3} MB: neighbours {:6.2f}, neighbours with a footprint of 4 texels "
            "{:6.2f}, anywhere {:6.2f}, anywhere with a footprint of 64 texels {:6.2f} M "
            "lookups/s\n",
            megabytes, rate(*textures, near, 0), rate(*textures, near, 4.0f / 2048),
            rate(*textures, far, 0), rate(*textures, far, 64.0f / 2048));
    }
}
