// Size and axes of a renderer that cannot say them itself, as parameters of a node.
#pragma once
#include <fmt/format.h>

#include "adaptive/sampler_function.h"
#include "runtime/node.h"

namespace weft::adaptive {

struct SamplerShape {
    int width = 320, height = 180;
    std::vector<std::string> axes{"t"};
    std::vector<float> scales;

    template <class Node>
    static void declare_shape(Ports<Node>& node) {
        const auto of = []<class T>(T SamplerShape::*field) {
            return static_cast<T Node::*>(field);
        };
        node.param("width", of(&SamplerShape::width),
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .param("height", of(&SamplerShape::height),
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .param("axes", of(&SamplerShape::axes),
                   {.about = "beside x and y: u v t light light-u light-v bounce-u bounce-v, or "
                             "names of its own"})
            .param("scales", of(&SamplerShape::scales),
                   {.unit = "px",
                    .min = 0,
                    .max = 65536,
                    .about = "of each of these: how far the picture moves over it; 16 where "
                             "nothing is said"});
    }
    SamplerFunction sampler() const {
        if (!scales.empty() && scales.size() != axes.size())
            throw Error(fmt::format("{} scales for {} axes; give one for each, or none",
                                    scales.size(), axes.size()));
        SamplerFunction made;
        made.width = width, made.height = height;
        made.axes = {{"x", float(width)}, {"y", float(height)}};
        for (size_t d = 0; d < axes.size(); ++d) {
            if (made.axis(axes[d]) >= 0)
                throw Error(
                    fmt::format("axis '{}' is there twice; x and y need not be said", axes[d]));
            made.axes.push_back({axes[d], scales.empty() ? 0 : scales[d]});
        }
        return made;
    }
};

// Channels by their standard names as features. Throws Error where there is no such.
inline std::vector<SamplerFeature> standard_features(const std::vector<std::string>& names) {
    std::vector<SamplerFeature> features;
    for (const std::string& name : names) {
        const int components = standard_components(name);
        if (components == 0)
            throw Error(fmt::format("no standard channel '{}'; see docs/formats.md", name));
        features.push_back({name, components});
    }
    return features;
}

}  // namespace weft::adaptive
