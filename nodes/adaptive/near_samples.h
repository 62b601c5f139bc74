// The samples of a Metrics around places.
#pragma once
#include "adaptive/least_distance_kernel.h"
#include "adaptive/metrics.h"
#include "adaptive/nearest_by_metric_kernel.h"

namespace weft::adaptive {

struct Block {
    float x0, y0, x1, y1;  // px
};

// Those within `reach` of any place of the block, at common numbers on all other axes, in the
// tree's order. `other`: px, on all axes but x and y, from index 2 on. True: all there are.
bool gather(const Metrics& metrics, const Block& block, const float* other, float reach,
            NearSamples& near);

// Those that may count somewhere between lo and hi, px on all axes.
void gather(const Metrics& metrics, const float* lo, const float* hi, NearbySamples& nearby);

// Entry of `upper` for row a, column b >= a, of a matrix of n rows.
constexpr size_t upper_index(size_t a, size_t b, size_t n) {
    return a * n - a * (a + 1) / 2 + b;
}

}  // namespace weft::adaptive
