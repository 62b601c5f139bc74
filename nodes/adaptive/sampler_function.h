// SamplerFunction, the value "Sampler": a renderer as a function of points, for nodes that choose
// themselves where to sample (Hachisuka et al. 2008). Graphs have no cycles, so the renderer
// travels as a value.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "samples/samples.h"

namespace weft {

// One axis of the domain. Points are in [0, 1] on every axis.
struct SamplerAxis {
    std::string name;  // x, y, u, v, t, light-u, light-v, bounce-u ...; x and y come first
    float scale =
        0;  // px: how far the picture moves over the axis, at a typical place; 0: not known
};

// What a sampler says of a point beside its radiance: a channel of docs/formats.md.
struct SamplerFeature {
    std::string name;
    int components = 1;
};

// Points, a structure of arrays: axes[d][i] in [0, 1]. u and v lie in the square, not on the disk,
// so that volumes keep their size.
struct SamplerPoints {
    std::span<const std::span<const float>> axes;
    size_t size() const { return axes.empty() ? 0 : axes[0].size(); }
};

class SamplerFunction {
  public:
    int width = 0, height = 0;  // px: x and y in [0, 1] are the film
    std::vector<SamplerAxis> axes;
    std::string color_space = "lin_rec709";
    std::vector<SamplerFeature> features;
    std::optional<Lens> lens;    // that u and v lie on; none: a round one, of unknown size
    Json meta = Json::object();  // of buffers made from it: source, shutter, camera, lights

    // Radiance and then features of points, values() numbers each. Pure: the same point and seed
    // give the same bits, on any thread, in any batch. What the axes leave open comes from a hash
    // of the point's bits and `hidden_seed`.
    std::function<void(const SamplerPoints&, std::uint64_t hidden_seed, std::span<float> values)>
        evaluate;

    size_t values() const {
        size_t all = 3;
        for (const SamplerFeature& feature : features) all += size_t(feature.components);
        return all;
    }
    size_t dimensions() const { return axes.size(); }
    size_t pixels() const { return size_t(width) * size_t(height); }
    int axis(std::string_view name) const {
        for (size_t d = 0; d < axes.size(); ++d)
            if (axes[d].name == name) return int(d);
        return -1;
    }
    size_t bytes() const { return sizeof *this; }
};

WEFT_VALUE_TYPE(SamplerFunction, "Sampler", "a renderer that can be asked for radiance at points")

}  // namespace weft
