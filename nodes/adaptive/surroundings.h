// The samples around each sample, bucket by bucket of their tree, and what they say of it:
// gradients, how well they predict it, whether they outshine each other. What
// structure_tensors_kernel.h makes metrics of.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "adaptive/neighbourhood_kernel.h"
#include "adaptive/structure_tensors_kernel.h"

namespace weft::adaptive {

// Of samples in the tree's order: places in px of scaled space on every axis, rgb 3 numbers each.
class Surroundings {
  public:
    Surroundings(const PointTree& tree, std::span<const float> rgb, const TensorSettings& settings);

    // What work on one bucket after another needs.
    struct Scratch {
        SamplesAround of_bucket, of_sample;
        Neighbourhood pooled, fitted, averaged;
    };
    // work(i, scratch) for each sample i, whose nearest ones by plain distance, as many as are ever
    // looked at, are scratch.of_sample. The first time finds out how far that is.
    template <class Work>
    void around_each(Context& ctx, Work&& work, const std::vector<char>* only = nullptr) {
        const bool known = known_;
        ctx.parallel(buckets_.size(), buckets_in_piece, [&](size_t begin, size_t end) {
            Scratch scratch;
            float reach = 1;
            for (size_t b = begin; b < end; ++b) {
                const auto [first, last] = buckets_[b];
                if (only && std::none_of(&(*only)[first], &(*only)[first] + (last - first),
                                         [](char chosen) { return chosen != 0; }))
                    continue;
                if (!known) {
                    reach = measure(b, 0.9f * reach, scratch);
                } else {
                    const float most = *std::max_element(within2_.begin() + std::ptrdiff_t(first),
                                                         within2_.begin() + std::ptrdiff_t(last));
                    gather(b, std::sqrt(most) * 1.0001f, scratch.of_bucket);
                }
                scratch.fitted.guess = scratch.averaged.guess = 0;
                std::array<const float*, most_axes> at{};
                for (size_t d = 0; d < axes_; ++d) at[d] = scratch.of_bucket.at[d].data();
                for (size_t i = first; i < last; ++i) {
                    if (only && !(*only)[i]) continue;
                    const auto centre = place_of(i);
                    scratch.of_sample.size = 0;
                    WEFT_PICK(append_within)
                    (at, scratch.of_bucket.place.data(), 0, scratch.of_bucket.size, axes_,
                     centre.data(), centre.data(), within2_[i], scratch.of_sample);
                    work(i, scratch);
                }
            }
        });
        known_ = true;
    }

    // About `count` neighbours of sample i, never fewer, itself among them: by the metric `upper`
    // (D (D + 1) / 2 numbers), or by plain distance where it is null.
    void find(size_t i, const float* upper, size_t count, const SamplesAround& around,
              Neighbourhood& found) const;

    // Fits sample i's gradients (radiance per px), notes least and most radiance around, and how
    // far the fit is off its own in made.radiance; tensors[averaged_stride(D) * i] on: its own.
    void fit(size_t i, const SamplesAround& around, Neighbourhood& near, Variation& made,
             std::vector<float>& tensors) const;

    // Whether radiance among them goes so far apart that a little of the brightest outshines the
    // darkest: what is mixed of them is no longer like any.
    bool outshines(size_t i, const SamplesAround& around, const Neighbourhood& near) const;
    // How much of a neighbourhood's variance is explained by a plane through it: next to nothing
    // of noise, a half of an edge.
    double explained(size_t i, const SamplesAround& around, Neighbourhood& near) const;
    // D (D + 1) / 2 numbers of a distance by place on the film, above all: another sample is within
    // half a pixel there.
    void local_metric(size_t i, float* upper) const;
    // How far a sample is from the one that is nearest by that one's metric, and from the nearest
    // by place: relative, squared.
    std::array<float, 2> predicted_off(size_t i, const SamplesAround& around,
                                       const Variation& made) const;

    Supports supports() const;

  private:
    static constexpr size_t buckets_in_piece = 64;

    // The diagonal of that distance's matrix: for x and y, and for each of the other axes.
    std::array<double, 2> local_of(size_t i) const;
    // How many samples around each are looked at.
    size_t reached() const;
    // The three nearest of a sample's neighbours, by how much nearer they are than the next; the
    // weights' sum is 1.
    struct Closest {
        size_t size = 0;
        std::array<std::uint32_t, 3> near{};
        std::array<double, 3> weight{};
    };
    static Closest closest_of(size_t i, const SamplesAround& around, const Neighbourhood& of);
    NeighbourSums sums_of(size_t i, const SamplesAround& around, Neighbourhood& near) const;
    // Of the regression of radiance on place, about the mean: the squares, factored, and a
    // channel's products.
    Matrix factored_squares(const NeighbourSums& sums, const Neighbourhood& of) const;
    std::array<double, most_axes> moments_of(const NeighbourSums& sums, size_t channel) const;
    // Brightness that differences are held against, as the eye sees it: without it, dark places
    // would vary least. From a sample's and how far its neighbours' mean is off.
    static double level_of(float radiance, double mean_off);
    std::array<float, most_axes> place_of(size_t i) const;
    // Finds how far samples of a bucket look; first within `reach` of it, then farther. How far it
    // took.
    float measure(size_t bucket, float reach, Scratch& scratch);
    void gather(size_t bucket, float reach, SamplesAround& around) const;

    const PointTree& tree_;
    const TensorSettings& settings_;
    size_t axes_;
    std::array<std::vector<float>, 3> channels_;
    std::array<const float*, 3> rgb_{};
    std::vector<std::pair<size_t, size_t>> buckets_;
    std::vector<float> within2_;  // px^2, of each sample: how far it looks
    bool known_ = false;          // whether that is found
};

}  // namespace weft::adaptive
