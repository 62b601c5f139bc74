// Points that somebody is asked about, as a sample buffer: how an adaptive sampling speaks with
// renderers that no node can call, and with graphs.
//   xy, uv, t ...  as samples have them, sorted by pixel
//   point          N x axes: the same in [0, 1], exactly
//   rgb            black: for the answers
//   request        N whole numbers: answers carry them, in any order
#pragma once
#include "adaptive/sampled_points.h"

namespace weft::adaptive {

// `points` axes x n; requests are numbered from `first` on.
Samples request_points(const SamplerFunction& sampler,
                       const std::vector<std::span<const float>>& points, std::uint32_t first);

// Channels of `answers` that say something of a point, beside where it is and its radiance.
std::vector<SamplerFeature> features_of(const Samples& answers);

// Radiance and `features` of requests first ... first + count - 1, in order, as they are.
// Throws Error where an answer is missing, there twice or was not asked for.
Evaluated answers_of(const Samples& answers, const std::vector<SamplerFeature>& features,
                     std::uint32_t first, size_t count);

// `point` of a buffer as axes x n. Throws Error, as `who`, where it has none of `axes` numbers.
std::vector<std::vector<float>> points_of(const Samples& requests, size_t axes,
                                          std::string_view who);

}  // namespace weft::adaptive
