// What would OpenImageIO's own TextureSystem make of the lookups of bench_texture_lookups?
// Input: the same noise, 2048 x 2048, as a tiled half picture with all its levels (make_texture);
// one thread, batches of the width that OpenImageIO was built for; a cache that holds all of it.
// Prints the median of 5 runs in million lookups a CPU second: trilinear, and the nearest texel of
// one level, which is as little as a lookup can do.
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/texture.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "bench/cpu_time.h"
#include "render/scene.h"
#include "samples/random.h"

using namespace weft;

namespace {

constexpr size_t count = 1 << 20, wide = OIIO::Tex::BatchWidth;

struct Rule {
    const char* name;
    OIIO::Tex::MipMode level;
    OIIO::Tex::InterpMode texel;
};

double rate(OIIO::TextureSystem& system, OIIO::ustring file, const Rule& rule,
            const std::vector<Vec2>& uv, float width) {
    OIIO::TextureOptBatch options;
    options.mipmode = rule.level;
    options.interpmode = rule.texel;
    options.swrap = options.twrap = OIIO::Tex::Wrap::Periodic;
    options.anisotropic = 1;
    alignas(OIIO::Tex::BatchAlign) float s[wide], t[wide], along[wide], none[wide] = {},
                                                                        result[4 * wide];
    std::fill_n(along, wide, width);
    std::fill_n(options.sblur, wide, 0.0f), std::fill_n(options.tblur, wide, 0.0f);
    std::fill_n(options.swidth, wide, 1.0f), std::fill_n(options.twidth, wide, 1.0f);
    auto* thread = system.get_perthread_info();
    auto* handle = system.get_texture_handle(file, thread);
    std::vector<double> runs;
    for (int run = 0; run < 5; ++run) {
        const double start = cpu_s();
        for (size_t i = 0; i < count; i += wide) {
            for (size_t k = 0; k < wide; ++k) {
                s[k] = uv[i + k].x, t[k] = uv[i + k].y;
                options.rnd[k] = unit_float(mix(i + k + 77));
            }
            if (!system.texture(handle, thread, options, OIIO::Tex::RunMaskOn, s, t, along, none,
                                none, along, 4, result)) {
                fmt::print("{}\n", system.geterror());
                return 0;
            }
        }
        runs.push_back(cpu_s() - start);
    }
    std::sort(runs.begin(), runs.end());
    return double(count) / runs[2] * 1e-6;
}

}  // namespace

int main() {
    OIIO::attribute("threads", 1);
    const std::string file = std::filesystem::temp_directory_path() / "weft-texture-system.exr";
    OIIO::ImageBuf noise(OIIO::ImageSpec(2048, 2048, 4, OIIO::TypeDesc::FLOAT));
    for (int y = 0; y < 2048; ++y)
        for (int x = 0; x < 2048; ++x) {
            float pixel[4] = {0, 0, 0, 1};
            for (int c = 0; c < 3; ++c) pixel[c] = unit_float(mix(size_t(3 * (2048 * y + x) + c)));
            noise.setpixel(x, y, pixel);
        }
    OIIO::ImageSpec config;
    config.set_format(OIIO::TypeDesc::HALF);
    if (!OIIO::ImageBufAlgo::make_texture(OIIO::ImageBufAlgo::MakeTxTexture, noise, file, config)) {
        fmt::print("{}\n", OIIO::geterror());
        return 1;
    }
    std::vector<Vec2> near(count), far(count);
    for (size_t i = 0; i < count; ++i) {
        near[i] = {float(i % 1024) / 1024, float(i / 1024) / 1024};
        far[i] = {unit_float(mix(2 * i)), unit_float(mix(2 * i + 1))};
    }
    OIIO::TextureSystem* system = OIIO::TextureSystem::create(false);
    system->attribute("max_memory_MB", 256.0f);
    using OIIO::Tex::InterpMode, OIIO::Tex::MipMode;
    for (const Rule& rule : {Rule{"trilinear", MipMode::Trilinear, InterpMode::Bilinear},
                             Rule{"nearest texel", MipMode::OneLevel, InterpMode::Closest}}) {
        const OIIO::ustring name(file);
        rate(*system, name, rule, near, 0);
        fmt::print(
            "{:13}: neighbours {:6.2f}, neighbours with a footprint of 4 texels {:6.2f}, anywhere "
            "{:6.2f}, anywhere with a footprint of 64 texels {:6.2f} M lookups/s\n",
            rule.name, rate(*system, name, rule, near, 0),
            rate(*system, name, rule, near, 4.0f / 2048), rate(*system, name, rule, far, 0),
            rate(*system, name, rule, far, 64.0f / 2048));
    }
    OIIO::TextureSystem::destroy(system);
    std::filesystem::remove(file);
}
