#include "adaptive/metrics.h"

#include "graph/error.h"

namespace weft {

Metrics metrics_over(const Samples& samples, const LeafTree* leaves, std::string_view who) {
    if (samples.size() == 0)
        throw Error("the buffer has no samples; sample at least one, or look at what dropped them");
    Metrics metrics;
    metrics.width = samples.width;
    metrics.height = samples.height;
    metrics.space = leaves ? adaptive::space_of(*leaves) : adaptive::space_of(samples);
    const auto places = adaptive::places_in(metrics.space, samples, who);
    metrics.tree = std::make_shared<const adaptive::PointTree>(
        std::vector<std::span<const float>>(places.begin(), places.end()));
    return metrics;
}

void Metrics::vary(std::span<const float> rgb, const adaptive::TensorSettings& settings,
                   Context& ctx) {
    std::vector<float> ordered;
    ordered.reserve(rgb.size());
    for (const std::uint32_t i : tree->order())
        ordered.insert(ordered.end(), &rgb[3 * size_t(i)], &rgb[3 * size_t(i)] + 3);
    adaptive::Variation found = adaptive::variation(*tree, ordered, settings, ctx);
    upper = std::move(found.upper);
    gradient = std::move(found.gradient);
    least = std::move(found.least);
    most = std::move(found.most);
    radiance = std::move(found.radiance);
    supports = std::move(found.supports);
}

bool has_hidden_noise(const Samples& samples) {
    const Json* part = samples.meta.find("hidden_noise");
    return part && part->is(Json::Kind::number) && part->number > 0;
}

void Metrics::describe(FieldVisitor& see) const {
    see.field("upper", std::span(upper), int(numbers()));
    if (tree) see.field("sample", tree->order());
}

}  // namespace weft
