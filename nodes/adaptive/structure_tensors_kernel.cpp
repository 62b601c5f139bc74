#include "adaptive/structure_tensors_kernel.h"

#include <algorithm>
#include <cmath>

#include "adaptive/neighbourhood_kernel.h"

namespace weft::adaptive {
namespace {

constexpr size_t buckets_in_piece = 64;
constexpr size_t pool_of = 2;  // times as many as are averaged are looked at

// The buckets of the tree, and all that its samples are looked at with.
class Surroundings {
  public:
    Surroundings(const PointTree& tree, std::span<const float> rgb, const TensorSettings& settings)
        : tree_(tree), settings_(settings), axes_(tree.dimensions()) {
        const size_t n = tree.size();
        for (size_t c = 0; c < 3; ++c) {
            channels_[c].resize(n);
            for (size_t i = 0; i < n; ++i) channels_[c][i] = rgb[3 * i + c];
            rgb_[c] = channels_[c].data();
        }
        tree.visit([](const float*, const float*, size_t) { return true; },
                   [&](size_t begin, size_t end) {
                       buckets_.push_back({begin, end});
                   });
        within2_.resize(n);
    }

    // work(i, around, neighbourhood) for each sample i, with about `count` neighbours: by metrics
    // of `upper`, or Euclidean where it is empty.
    template <class Work>
    void around_each(const std::vector<float>& upper, size_t count, Context& ctx, Work&& work) {
        const size_t numbers = axes_ * (axes_ + 1) / 2, wanted = std::min(count, tree_.size()),
                     pool = reached();
        ctx.parallel(buckets_.size(), buckets_in_piece, [&](size_t begin, size_t end) {
            SamplesAround around;
            Neighbourhood found, pooled;
            std::array<float, most_axes> centre{};
            float reach = 1;
            for (size_t b = begin; b < end; ++b) {
                const auto [first, last] = buckets_[b];
                const auto at = [&](size_t i) {
                    for (size_t d = 0; d < axes_; ++d) centre[d] = tree_.at(d)[i];
                    return centre.data();
                };
                if (upper.empty()) {
                    reach *= 0.9f;
                    gather(b, reach, around);
                    for (size_t i = first; i < last; ++i) {
                        while (!WEFT_PICK(find_neighbours)(around, axes_, at(i), nullptr,
                                                           reach * reach, pool, pooled)) {
                            reach *= 1.3f;
                            gather(b, reach, around);
                        }
                        within2_[i] = pooled.radius2;
                    }
                } else {
                    float most = 0;
                    for (size_t i = first; i < last; ++i) most = std::max(most, within2_[i]);
                    gather(b, std::sqrt(most) * 1.0001f, around);
                }
                found.guess = 0;
                for (size_t i = first; i < last; ++i) {
                    WEFT_PICK(find_neighbours)
                    (around, axes_, at(i), upper.empty() ? nullptr : &upper[numbers * i],
                     within2_[i], wanted, found);
                    work(i, around, found);
                }
            }
        });
    }

    // Fits gradients, notes limits, and makes each sample's own tensor.
    void fit(size_t i, const SamplesAround& around, Neighbourhood& near, Variation& made,
             std::vector<float>& tensors) const {
        std::array<float, most_axes> centre{};
        for (size_t d = 0; d < axes_; ++d) centre[d] = tree_.at(d)[i];
        const NeighbourSums sums =
            WEFT_PICK(sum_neighbours)(around, axes_, centre.data(), rgb_, std::uint32_t(i), near);
        float* gradient = &made.gradient[3 * axes_ * i];
        std::fill_n(gradient, 3 * axes_, 0.0f);
        for (size_t c = 0; c < 3; ++c) {
            made.least[3 * i + c] = sums.least[c];
            made.most[3 * i + c] = sums.most[c];
        }
        float* tensor = &tensors[axes_ * (axes_ + 1) / 2 * i];
        std::fill_n(tensor, axes_ * (axes_ + 1) / 2, 0.0f);
        if (!(near.radius2 > 0)) return;  // all in one place: nothing is known, and 0 says so
        const double w = double(sums.w);
        Matrix squares{};
        size_t k = 0;
        for (size_t a = 0; a < axes_; ++a)
            for (size_t b = a; b < axes_; ++b, ++k)
                squares[b][a] = double(sums.dd[k]) - double(sums.d[a]) * double(sums.d[b]) / w;
        for (size_t a = 0; a < axes_; ++a)
            squares[a][a] += double(settings_.ridge) * double(near.radius2);
        factor(squares, axes_);
        for (size_t c = 0; c < 3; ++c) {
            std::array<double, most_axes> slope{};
            for (size_t a = 0; a < axes_; ++a)
                slope[a] =
                    double(sums.df[c * axes_ + a]) - double(sums.d[a]) * double(sums.f[c]) / w;
            solve_factored(squares, axes_, slope);
            // Against brightness, as the eye sees it: without it, dark places would vary least.
            const double level = std::max(double(rgb_[c][i]) + double(sums.f[c]) / w, 0.0) + 0.1;
            size_t at = 0;
            for (size_t a = 0; a < axes_; ++a) {
                gradient[axes_ * c + a] = float(slope[a]);
                for (size_t b = a; b < axes_; ++b, ++at)
                    tensor[at] += float(slope[a] * slope[b] / (level * level));
            }
        }
    }

    size_t reached() const {
        return std::min(tree_.size(),
                        pool_of * std::max(settings_.averaged, settings_.neighbours) + 1);
    }
    Supports supports() const {
        const double part = double(std::min(samples_in_support, tree_.size())) /
                            double(std::max<size_t>(1, reached()));
        const float share = float(std::pow(part, 2 / double(axes_)));
        Supports made;
        for (const float squared : within2_) made.squared.push_back(share * squared);
        made.of_node = tree_.largest(made.squared);
        return made;
    }

  private:
    void gather(size_t bucket, float reach, SamplesAround& around) const {
        const auto [first, last] = buckets_[bucket];
        std::array<float, most_axes> lo{}, hi{};
        for (size_t d = 0; d < axes_; ++d) {
            const auto [least, most] =
                std::minmax_element(tree_.at(d).begin() + std::ptrdiff_t(first),
                                    tree_.at(d).begin() + std::ptrdiff_t(last));
            lo[d] = *least, hi[d] = *most;
        }
        for (size_t d = 0; d < axes_; ++d) around.at[d].clear();
        around.place.clear();
        tree_.visit(
            [&](const float* from, const float* to, size_t) {
                float off2 = 0;
                for (size_t d = 0; d < axes_; ++d) {
                    const float off = std::max({from[d] - hi[d], lo[d] - to[d], 0.0f});
                    off2 += off * off;
                }
                return off2 <= reach * reach;
            },
            [&](size_t begin, size_t end) {
                for (size_t d = 0; d < axes_; ++d)
                    around.at[d].insert(around.at[d].end(),
                                        tree_.at(d).begin() + std::ptrdiff_t(begin),
                                        tree_.at(d).begin() + std::ptrdiff_t(end));
                for (size_t i = begin; i < end; ++i) around.place.push_back(std::uint32_t(i));
            });
        around.size = around.place.size();
        for (size_t d = 0; d < axes_; ++d) around.at[d].resize((around.size + 15) / 16 * 16, 1e18f);
    }

    const PointTree& tree_;
    const TensorSettings& settings_;
    size_t axes_;
    std::array<std::vector<float>, 3> channels_;
    std::array<const float*, 3> rgb_{};
    std::vector<std::pair<size_t, size_t>> buckets_;
    std::vector<float> within2_;  // of each sample: how far it looks
};

// A metric without eigenvalues: the tensor, so much of its trace that none is below `floor`, over
// the root of its determinant. For rounds that another follows.
void quick_metric(const float* tensor, size_t n, float floor, float* upper) {
    double trace = 0;
    Matrix m{};
    size_t k = 0;
    for (size_t a = 0; a < n; ++a)
        for (size_t b = a; b < n; ++b, ++k) m[b][a] = double(tensor[k]);
    for (size_t a = 0; a < n; ++a) trace += m[a][a];
    if (!(trace >= 1e-10)) trace = 1, m = Matrix{};
    for (size_t a = 0; a < n; ++a) m[a][a] += double(floor) * trace;
    double determinant = 1;
    Matrix root = m;
    factor(root, n, 1e-9 * trace);
    for (size_t i = 0; i < n; ++i) determinant *= root[i][i] * root[i][i];
    const double scale = std::exp(-std::log(determinant) / double(n));
    k = 0;
    for (size_t a = 0; a < n; ++a)
        for (size_t b = a; b < n; ++b) upper[k++] = float(scale * m[b][a]);
}

}  // namespace

Supports supports_of(const PointTree& tree, Context& ctx) {
    const std::vector<float> none(3 * tree.size());
    const TensorSettings settings;
    Surroundings samples(tree, none, settings);
    samples.around_each({}, 1, ctx, [](size_t, const SamplesAround&, Neighbourhood&) {});
    return samples.supports();
}

Variation variation(const PointTree& tree, std::span<const float> rgb,
                    const TensorSettings& settings, Context& ctx) {
    const size_t n = tree.size(), axes = tree.dimensions(), numbers = axes * (axes + 1) / 2;
    Variation made;
    made.gradient.resize(3 * axes * n);
    made.least.resize(3 * n), made.most.resize(3 * n);
    std::vector<float> own(numbers * n), upper(numbers * n);
    Surroundings samples(tree, rgb, settings);
    for (float floor = first_floor;; floor *= floor_of_round) {
        const bool last = floor <= settings.floor * 1.001f || first_floor <= settings.floor;
        const float here = last ? settings.floor : floor;
        samples.around_each(made.upper, settings.neighbours + 1, ctx,
                            [&](size_t i, const SamplesAround& around, Neighbourhood& near) {
                                samples.fit(i, around, near, made, own);
                            });
        samples.around_each(made.upper, settings.averaged + 1, ctx,
                            [&](size_t i, const SamplesAround& around, Neighbourhood& near) {
                                std::array<float, most_axes*(most_axes + 1) / 2> mean{};
                                WEFT_PICK(mean_of_neighbours)
                                (around, own.data(), numbers, near, mean.data());
                                if (!last) {
                                    quick_metric(mean.data(), axes, here, &upper[numbers * i]);
                                    return;
                                }
                                Matrix tensor{};
                                size_t k = 0;
                                for (size_t a = 0; a < axes; ++a)
                                    for (size_t b = a; b < axes; ++b, ++k)
                                        tensor[a][b] = tensor[b][a] = double(mean[k]);
                                metric_of(tensor, axes, here, &upper[numbers * i]);
                            });
        made.upper = upper;
        if (!last) continue;
        made.supports = samples.supports();
        return made;
    }
}

void metric_of(const Matrix& tensor, size_t n, float floor, float* upper) {
    Matrix vectors;
    std::array<double, most_axes> values = eigen(tensor, n, vectors);
    const double largest = *std::max_element(values.begin(), values.begin() + std::ptrdiff_t(n));
    if (!(largest >= 1e-10)) {
        values.fill(1);
    } else {
        double logs = 0;
        for (size_t k = 0; k < n; ++k) {
            values[k] = std::max(values[k], double(floor) * largest);
            logs += std::log(values[k]);
        }
        const double mean = std::exp(logs / double(n));
        for (size_t k = 0; k < n; ++k) values[k] /= mean;
    }
    for (size_t a = 0; a < n; ++a)
        for (size_t b = a; b < n; ++b) {
            double sum = 0;
            for (size_t k = 0; k < n; ++k) sum += values[k] * vectors[a][k] * vectors[b][k];
            *upper++ = float(sum);
        }
}

}  // namespace weft::adaptive
