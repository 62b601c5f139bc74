// Points of a SamplerFunction as a sample buffer.
#pragma once
#include <span>
#include <vector>

#include "adaptive/sampler_function.h"
#include "runtime/context.h"
#include "samples/samples.h"

namespace weft::adaptive {

// Evaluates points (axes x n, in [0, 1]) in parallel. Radiance that is not finite becomes 0; how
// many were is added to `broken`.
std::vector<float> evaluate(const SamplerFunction& sampler,
                            const std::vector<std::span<const float>>& axes,
                            std::uint64_t hidden_seed, size_t& broken, Context& ctx);

// Warns of points without finite radiance; fails where they are more than one in a hundred.
void judge_broken(size_t broken, size_t all, Context& ctx);

// A buffer of points (axes x n, in [0, 1]) with a varying number of samples a pixel: xy, uv (on the
// disk) and t as the axes have them, rgb, any other axis under its own name, and `weight` unless it
// is empty. `order` gets where each sample of the buffer was among the points.
Samples samples_of(const SamplerFunction& sampler, const std::vector<std::span<const float>>& axes,
                   std::span<const float> rgb, std::span<const float> weight,
                   std::vector<std::uint32_t>& order);

}  // namespace weft::adaptive
