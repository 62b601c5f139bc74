// Which way radiance varies around each sample: gradients in scaled space, and metrics from them.
// Source: after Hachisuka et al. 2008, whose metric is the structure tensor of a leaf's samples.
// Departure: gradients by weighted least squares over the nearest samples, tensors averaged over
// the same, metrics of determinant 1, so that volumes compare from sample to sample.
#pragma once
#include <span>
#include <vector>

#include "adaptive/point_tree.h"
#include "adaptive/symmetric.h"
#include "runtime/context.h"

namespace weft::adaptive {

struct TensorSettings {
    size_t neighbours = 48;
    float floor = 0.05f;  // least eigenvalue, over the largest
    float ridge = 1e-6f;  // of the least squares, over the neighbourhood's radius squared
};

// Samples in the tree's order: rgb 3 a sample. Gradients: 3 x D a sample, radiance per px.
std::vector<float> gradients(const PointTree& tree, std::span<const float> rgb,
                             const TensorSettings& settings, Context& ctx);
// Upper triangles by rows, D (D + 1) / 2 a sample.
std::vector<float> structure_metrics(const PointTree& tree, std::span<const float> rgb,
                                     std::span<const float> gradients,
                                     const TensorSettings& settings, Context& ctx);

// The metric of a structure tensor: eigenvalues not below `floor` of the largest, over their
// geometric mean. Without variation: the identity.
void metric_of(const Matrix& tensor, size_t n, float floor, float* upper);

}  // namespace weft::adaptive
