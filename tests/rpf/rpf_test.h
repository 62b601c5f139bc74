// Sample buffers with features, of which a test knows what depends on what.
#pragma once
#include <cmath>
#include <functional>

#include "rpf/kernels.h"
#include "tests/instruction_sets.h"
#include "tests/run_node.h"
#include "tests/sample_buffer.h"

namespace weft {

inline float chance(std::uint64_t seed, std::uint64_t i) {
    return unit_float(mix(seed * 0x9e3779b9ull + mix(i)));
}

// What a sample's numbers are made of: film position and four random parameters.
struct Drawn {
    float x, y, u, v, t, l;
};
using Color = std::function<float(const Drawn&)>;

using Count = std::function<size_t(size_t)>;

// Features: albedo as given, a tilted plane's position, one normal that wobbles a little.
// count_of(pixel) samples a pixel.
inline Samples feature_samples(int width, int height, const Count& count_of, const Color& color,
                               const Color& albedo, std::uint64_t seed = 1) {
    Samples s = placed_samples(width, height, count_of, [&](size_t i) {
        return std::array{chance(seed, 8 * i), chance(seed, 8 * i + 1)};
    });
    const size_t n = s.size();
    std::vector<float> uv, t, z(n, 4.0f), light, position, normal, shade, rgb;
    for (size_t i = 0; i < n; ++i) {
        const Drawn d{s.xy()[2 * i],
                      s.xy()[2 * i + 1],
                      2 * chance(seed, 8 * i + 2) - 1,
                      2 * chance(seed, 8 * i + 3) - 1,
                      chance(seed, 8 * i + 4),
                      chance(seed, 8 * i + 5)};
        uv.insert(uv.end(), {0.7f * d.u, 0.7f * d.v});
        t.push_back(d.t);
        light.insert(light.end(), {d.l, chance(seed, 8 * i + 6)});
        position.insert(position.end(), {0.1f * d.x, 0.1f * d.y, 0.05f * d.x});
        normal.insert(normal.end(), {0, 0, 1 + 1e-3f * chance(seed, 8 * i + 7)});
        const float a = albedo(d), c = color(d);
        shade.insert(shade.end(), {a, a, 0.5f * a});
        rgb.insert(rgb.end(), {c, 0.5f * c, 0.25f * c});
    }
    s.add("uv", 2, uv);
    s.add("t", 1, t);
    s.add("z", 1, z);
    s.add("light_uv", 2, light);
    s.add("position", 3, position);
    s.add("normal", 3, normal);
    s.add("albedo", 3, shade);
    s.add("rgb", 3, rgb);
    return s;
}
inline Samples feature_samples(int width, int height, int spp, const Color& color,
                               const Color& albedo, std::uint64_t seed = 1) {
    return feature_samples(
        width, height, [&](size_t) { return size_t(spp); }, color, albedo, seed);
}

inline SampleVectors vectors_of(const Samples& samples) {
    return RunNode("build-vectors").in("samples", samples).out<SampleVectors>("vectors");
}

}  // namespace weft
