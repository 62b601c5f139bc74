#include "adaptive/metrics.h"

namespace weft {

void Metrics::describe(FieldVisitor& see) const {
    see.field("upper", std::span(upper), int(numbers()));
    if (tree) see.field("sample", tree->order());
}

}  // namespace weft
