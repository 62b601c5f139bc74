#include "rpf/sample_vectors.h"

namespace weft {

SampleVectors::Range SampleVectors::of_channel(size_t channel) const {
    Range range{0, 0};
    while (range.begin < components.size() && size_t(components[range.begin].channel) != channel)
        ++range.begin;
    range.end = range.begin;
    while (range.end < components.size() && size_t(components[range.end].channel) == channel)
        ++range.end;
    return range;
}

}  // namespace weft
