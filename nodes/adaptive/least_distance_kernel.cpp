// Compiled once an instruction set. Loops are written for the compiler to make vectors of: no early
// exits, least values as whole numbers.
#include "adaptive/least_distance_kernel.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace weft::adaptive::WEFT_ISA {
namespace {

constexpr std::int32_t largest = std::numeric_limits<std::int32_t>::max();

struct Measured {
    std::int32_t within = 0;       // samples within reach
    std::int32_t least = largest;  // of all, by metric
};
// Fills both distances.
Measured measure(const NearSamples& near, float x, float y, float reach2, size_t n,
                 float* __restrict distance2, std::int32_t* __restrict by_metric) {
    const float *nx = near.x.data(), *ny = near.y.data(), *off2 = near.off2.data(),
                *xx = near.xx.data(), *xy = near.xy.data(), *yy = near.yy.data(),
                *bx = near.bx.data(), *by = near.by.data(), *rest = near.rest.data();
    std::int32_t within = 0, least = largest;
    for (size_t i = 0; i < n; ++i) {
        const float dx = x - nx[i], dy = y - ny[i];
        const float d2 = dx * dx + dy * dy + off2[i];
        float q =
            dx * (xx[i] * dx + 2 * (xy[i] * dy + bx[i])) + dy * (yy[i] * dy + 2 * by[i]) + rest[i];
        q = q > 0 ? q : 0;  // rounding
        distance2[i] = d2;
        const std::int32_t bits = std::bit_cast<std::int32_t>(q);
        by_metric[i] = bits;
        least = bits < least ? bits : least;
        within += d2 <= reach2 ? 1 : 0;
    }
    return {within, least};
}

}  // namespace

// The sample of least distance by metric, of those nearer than `bound`; if it is not among the
// candidates, none that is as far off is one either, and so on.
std::int32_t least_distance(const NearSamples& near, float x, float y, std::int32_t candidates,
                            float reach2, LeastDistance& scratch) {
    const size_t n = near.x.size();
    if (scratch.distance2.size() < n) scratch.distance2.resize(n), scratch.by_metric.resize(n);
    float* __restrict distance2 = scratch.distance2.data();
    std::int32_t* __restrict by_metric = scratch.by_metric.data();
    const auto [within, of_all] = measure(near, x, y, reach2, n, distance2, by_metric);
    if (within < candidates) return not_known;
    float bound = std::numeric_limits<float>::infinity();
    for (std::int32_t least = of_all;;) {
        std::int32_t winner = largest;
        for (size_t i = 0; i < n; ++i) {
            const bool is = (by_metric[i] == least) & (distance2[i] < bound);
            const std::int32_t here = is ? std::int32_t(i) : largest;
            winner = here < winner ? here : winner;
        }
        if (winner == largest) return not_known;
        const float distance = distance2[winner];
        std::int32_t nearer = 0;
        for (size_t i = 0; i < n; ++i) nearer += distance2[i] < distance ? 1 : 0;
        if (nearer < candidates) return winner;
        bound = distance;
        least = largest;
        for (size_t i = 0; i < n; ++i) {
            const std::int32_t here = distance2[i] < bound ? by_metric[i] : largest;
            least = here < least ? here : least;
        }
    }
}

}  // namespace weft::adaptive::WEFT_ISA
