// Which way radiance varies around each sample: gradients in scaled space, and metrics from them.
// Source: after Hachisuka et al. 2008, whose metric is the structure tensor of a leaf's samples.
// Departure: gradients by weighted least squares over the nearest samples, tensors averaged over
// more of them, metrics of determinant 1, so that volumes compare from sample to sample. And in
// rounds: what is nearest is told by the metric of the round before, which is let grow longer from
// round to round. Isotropic neighbourhoods wide enough for a fit blur what is finer than they are;
// those that follow an edge or a moving texture hold as many samples and are thinner.
//   What no axis explains is noise, which nearness does not tell from variation. So each sample is
//   predicted without itself twice, from its three nearest and from the fit to all its neighbours;
//   where the fit predicts the samples around better, radiance goes as far towards it as predicts
//   best (stacked regression, Wolpert 1992; Breiman 1996).
//   Where some samples outshine others, as a lamp does the wall beside it, a little of the bright
//   carried too far is all of the error. There gradients are not followed, and the metric is kept
//   only where it predicts samples from the others better by far than nearness on the film does. Not
// where noise is most of it: a sample that a light reached by chance outshines those it did not.
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "adaptive/point_tree.h"
#include "adaptive/symmetric.h"
#include "runtime/context.h"

namespace weft::adaptive {

struct TensorSettings {
    size_t neighbours = 24;  // a gradient is fitted to; twice as many with `smooth`
    size_t averaged = 96;    // a tensor is the mean of
    float floor = 0.001f;    // least eigenvalue, over the largest
    float ridge = 1e-6f;     // of the least squares, over the neighbourhood's radius squared
    bool smooth = false;     // whether radiance goes towards what is fitted
};
// Least eigenvalue over the largest, after the first round, and of that after each further one.
inline constexpr float first_floor = 0.05f, floor_of_round = 0.25f;

// Whether `most` outshines `least`: a sixteenth of it, as 0.1 is added to both, is brighter.
inline bool outshine(float least, float most) {
    return most + 0.1f > 16 * (std::max(least, 0.0f) + 0.1f);
}

// How far each sample counts, squared: as far as about 64 others lie around it, as if those looked
// at were spread evenly. And of each node of the tree the farthest.
struct Supports {
    std::vector<float> squared, of_node;
};
inline constexpr size_t samples_in_support = 64;
Supports supports_of(const PointTree& tree, Context& ctx);

// What the samples around each say of it, in the tree's order.
struct Variation {
    std::vector<float> upper;        // metrics: upper triangles by rows, D (D + 1) / 2 a sample
    std::vector<float> gradient;     // 3 x D a sample, radiance per px
    std::vector<float> least, most;  // 3 a sample: radiance among the gradient's neighbours
    std::vector<float> radiance;     // 3 a sample: its own, or nearer to what is fitted
    Supports supports;
};

// Samples in the tree's order: rgb 3 a sample. Same bits for any number of threads.
Variation variation(const PointTree& tree, std::span<const float> rgb,
                    const TensorSettings& settings, Context& ctx);

// The metric of a structure tensor: eigenvalues not below `floor` of the largest, over their
// geometric mean. Without variation: the identity.
void metric_of(const Matrix& tensor, size_t n, float floor, float* upper);

}  // namespace weft::adaptive
