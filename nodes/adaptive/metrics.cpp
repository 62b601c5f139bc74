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

void Metrics::describe(FieldVisitor& see) const {
    see.field("upper", std::span(upper), int(numbers()));
    if (tree) see.field("sample", tree->order());
}

}  // namespace weft
