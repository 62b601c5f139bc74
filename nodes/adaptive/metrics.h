// Metrics: which way the picture varies around each sample, over all axes: a distance of its own
// for each, in which what is alike is near.
#pragma once
#include <memory>

#include "adaptive/point_tree.h"
#include "adaptive/scaled_space.h"
#include "adaptive/structure_tensors_kernel.h"
#include "runtime/value.h"

namespace weft {

struct Metrics {
    int width = 0, height = 0;  // px
    adaptive::ScaledSpace space;
    std::shared_ptr<const adaptive::PointTree> tree;  // the samples in it
    // In the tree's order.
    std::vector<float> upper;        // upper triangle by rows, determinant 1
    std::vector<float> gradient;     // 3 x D, radiance per px; empty: not known
    std::vector<float> least, most;  // 3: between what radiance stays nearby
    std::vector<float> radiance;     // 3, with noise taken off; empty: the samples' own
    adaptive::Supports supports;     // how far each counts

    size_t dimensions() const { return space.axes.size(); }
    size_t size() const { return tree ? tree->size() : 0; }
    size_t numbers() const { return dimensions() * (dimensions() + 1) / 2; }  // of a sample
    size_t bytes() const {
        return 4 * (upper.size() + gradient.size() + least.size() + most.size() + radiance.size() +
                    supports.squared.size() + size() * (dimensions() + 1));
    }
    void count(Items& items) const { items.add("samples", size()); }
    void describe(FieldVisitor& see) const;

    // Finds distances and gradients from how radiance varies: rgb three a sample, in the buffer's
    // order.
    void vary(std::span<const float> rgb, const adaptive::TensorSettings& settings, Context& ctx);
};

// Space and tree of a buffer's samples, no distances yet; axes of `leaves` where there are some.
// Throws Error, as `who`, where there are no samples or an axis is missing.
Metrics metrics_over(const Samples& samples, const LeafTree* leaves, std::string_view who);

// Whether adaptive-samples found that no axis explains the noise of this buffer.
bool has_hidden_noise(const Samples& samples);

WEFT_VALUE_TYPE(Metrics, "Metrics", "a distance around each sample, of all its axes")

}  // namespace weft
