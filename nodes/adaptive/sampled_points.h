// Points of a SamplerFunction as a sample buffer.
#pragma once
#include <span>
#include <vector>

#include "adaptive/sampler_function.h"
#include "runtime/context.h"
#include "samples/samples.h"

namespace weft::adaptive {

struct Evaluated {
    std::vector<float> rgb;       // 3 a point
    std::vector<float> features;  // as many a point as the sampler's features have, together
    size_t broken = 0;            // points whose radiance was not finite, and is 0 now
};
// Evaluates points (axes x n, in [0, 1]) in parallel.
Evaluated evaluate(const SamplerFunction& sampler, const std::vector<std::span<const float>>& axes,
                   std::uint64_t hidden_seed, Context& ctx);

// Makes radiance that is not finite black; counts such points.
size_t blacken_broken(std::span<float> rgb);

// Warns of points without finite radiance; fails where they are more than one in a hundred.
void judge_broken(size_t broken, size_t all, Context& ctx);

// A buffer of points (axes x n, in [0, 1]) with a varying number of samples a pixel: xy, uv (on the
// lens) and t as the axes have them, rgb, features, any other axis under its own name, and `weight`
// unless it is empty. `order` gets where each sample of the buffer was among the points.
Samples samples_of(const SamplerFunction& sampler, const std::vector<std::span<const float>>& axes,
                   const Evaluated& values, std::span<const float> weight,
                   std::vector<std::uint32_t>& order);

}  // namespace weft::adaptive
