#include "adaptive/anisotropic_radiance.h"

#include <algorithm>
#include <cmath>

#include "adaptive/with_axes.h"

namespace weft::adaptive {

// False where samples farther than the square root of `within2` would have to be known.
bool AnisotropicRadiance::nearest(const float* place, float within2, Scratch& scratch,
                                  float* to) const {
    const std::int32_t winner = WEFT_PICK(least_distance)(scratch.near, place[0], place[1], wanted_,
                                                          within2, scratch.distances);
    if (winner == not_known) return false;
    radiance(scratch.near.place[size_t(winner)], place, to);
    return true;
}

// A weight is 0 where the fourth is as near, so that a sample comes in without a step. What all say
// alike stays as it is, to the bit. Where no sample counts, far from all, the nearest one does.
void AnisotropicRadiance::mix(const float* place, size_t i, Scratch& scratch, float* to) const {
    const NearestSamples& nearest = scratch.nearest;
    std::array<float, NearestSamples::most> distance;
    size_t size = 0;
    for (; size < distance.size() && nearest.distance2[size][i] < NearestSamples::none; ++size)
        distance[size] = std::sqrt(nearest.distance2[size][i]);
    if (size == 0) {
        metrics_.tree->nearest(place, 1, scratch.found);
        radiance(scratch.found[0].place, place, to);
        return;
    }
    const float far = size > 3 ? distance[3] : 2 * distance[size - 1];
    float sum[3] = {}, first[3] = {}, weights = 0;
    float least[3], most[3];
    for (size_t k = 0; k < std::min(size_t(3), size); ++k) {
        const float weight = far > 0 ? 1 - distance[k] / far : 1;
        float value[3];
        radiance(scratch.counting.place[nearest.sample[k][i]], place, value);
        for (size_t c = 0; c < 3; ++c) {
            if (k == 0) first[c] = least[c] = most[c] = value[c];
            least[c] = std::min(least[c], value[c]), most[c] = std::max(most[c], value[c]);
            sum[c] += weight * (value[c] - first[c]);
        }
        weights += weight;
    }
    for (size_t c = 0; c < 3; ++c)
        if (outshine(least[c], most[c])) weights = 0;  // the nearest decides
    for (size_t c = 0; c < 3; ++c) to[c] = weights > 0 ? first[c] + sum[c] / weights : first[c];
}

// What a sample says of a place.
void AnisotropicRadiance::radiance(size_t in_tree, const float* place, float* to) const {
    std::copy_n(&rgb_[3 * size_t(metrics_.tree->order()[in_tree])], 3, to);
    if (blend_ != Blend::linear || metrics_.gradient.empty()) return;
    if (!metrics_.radiance.empty()) std::copy_n(&metrics_.radiance[3 * in_tree], 3, to);
    with_axes(metrics_.dimensions(), [&](auto axes) {
        constexpr size_t n = axes.value;
        const float* gradient = &metrics_.gradient[3 * n * in_tree];
        float off[n];
        for (size_t d = 0; d < n; ++d) off[d] = place[d] - metrics_.tree->at(d)[in_tree];
        for (size_t c = 0; c < 3; ++c) {
            for (size_t d = 0; d < n; ++d) to[c] += *gradient++ * off[d];
            to[c] =
                std::clamp(to[c], metrics_.least[3 * in_tree + c], metrics_.most[3 * in_tree + c]);
        }
    });
}

}  // namespace weft::adaptive
