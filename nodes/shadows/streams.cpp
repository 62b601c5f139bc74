#include "shadows/streams.h"

#include <algorithm>
#include <span>

namespace weft {
namespace {

template <class T>
std::span<const T> head(const std::vector<T>& values, size_t n) {
    return std::span<const T>(values).first(std::min(n, values.size()));
}

}  // namespace

void SeenSamples::describe(FieldVisitor& see) const {
    see.field("sample", head(sample, size()));
}

void ShadowQueries::describe(FieldVisitor& see) const {
    see.field("inverse-depth", head(inverse_depth, size()));
    see.field("sample", head(sample, size()));
    if (!answer_of.empty()) see.field("answer-of", head(answer_of, size()));
}

void LightShares::describe(FieldVisitor& see) const {
    see.field("share", head(share, size()));
    see.field("votes", head(votes, size()));
}

}  // namespace weft
