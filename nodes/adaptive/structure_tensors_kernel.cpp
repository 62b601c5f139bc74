#include "adaptive/structure_tensors_kernel.h"

#include <algorithm>
#include <cmath>

#include "adaptive/neighbourhood_kernel.h"
#include "adaptive/with_axes.h"

namespace weft::adaptive {
namespace {

constexpr size_t buckets_in_piece = 64;
constexpr float rounding = 1e-10f;  // squares of differences, against brightness, that say nothing
constexpr size_t pool_of = 2;       // times as many as are averaged are looked at

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

    // What work on one bucket after another needs.
    struct Scratch {
        SamplesAround of_bucket, of_sample;
        Neighbourhood pooled, fitted, averaged;
    };
    // work(i, scratch) for each sample i, whose nearest ones by plain distance, as many as are ever
    // looked at, are scratch.of_sample. The first time finds out how far that is.
    template <class Work>
    void around_each(Context& ctx, Work&& work) {
        const bool known = known_;
        ctx.parallel(buckets_.size(), buckets_in_piece, [&](size_t begin, size_t end) {
            Scratch scratch;
            float reach = 1;
            for (size_t b = begin; b < end; ++b) {
                const auto [first, last] = buckets_[b];
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

    // About `count` neighbours by the metric `upper`, or by plain distance where it is null.
    void find(size_t i, const float* upper, size_t count, const SamplesAround& around,
              Neighbourhood& found) const {
        WEFT_PICK(find_neighbours)
        (around, axes_, place_of(i).data(), upper, within2_[i], std::min(count, tree_.size()),
         found);
    }

    // Fits gradients, notes limits, and makes each sample's own tensor.
    void fit(size_t i, const SamplesAround& around, Neighbourhood& near, Variation& made,
             std::vector<float>& tensors) const {
        const auto centre = place_of(i);
        const NeighbourSums sums =
            WEFT_PICK(sum_neighbours)(around, axes_, centre.data(), rgb_, std::uint32_t(i), near);
        float* gradient = &made.gradient[3 * axes_ * i];
        std::fill_n(gradient, 3 * axes_, 0.0f);
        for (size_t c = 0; c < 3; ++c) {
            made.least[3 * i + c] = sums.least[c];
            made.most[3 * i + c] = sums.most[c];
            made.radiance[3 * i + c] = 0;
        }
        float* tensor = &tensors[averaged_stride(axes_) * i];
        std::fill_n(tensor, averaged_stride(axes_), 0.0f);
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
        const Closest closest = closest_of(i, around, near);
        // How much of the fit at the sample's place is its own doing; its weight is 1.
        std::array<double, most_axes> middle{};
        for (size_t a = 0; a < axes_; ++a) middle[a] = double(sums.d[a]) / w;
        std::array<double, most_axes> turned = middle;
        solve_factored(squares, axes_, turned);
        double own_part = 1 / w;
        for (size_t a = 0; a < axes_; ++a) own_part += middle[a] * turned[a];
        const double others = std::max(1 - own_part, 1e-3);
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
            // What is fitted here, and what others say, by the fit and by the closest ones: all as
            // differences to the sample's radiance.
            double fitted = double(sums.f[c]) / w;
            for (size_t a = 0; a < axes_; ++a) fitted -= slope[a] * middle[a];
            made.radiance[3 * i + c] = float(fitted);
            const double by_fit = fitted / others;
            double by_closest = 0;
            for (size_t n = 0; n < closest.size; ++n) {
                const size_t j = closest.near[n];
                double said = double(rgb_[c][around.place[j]]) - double(rgb_[c][i]);
                for (size_t a = 0; a < axes_; ++a)
                    said -= slope[a] * double(around.at[a][j] - centre[a]);
                by_closest += closest.weight[n] * said;
            }
            const double more = (by_fit - by_closest) / (level * level);
            tensor[at] += float(-by_closest * more);
            tensor[at + 1] += float((by_fit - by_closest) * more);
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
    // The three nearest of a sample's neighbours, by how much nearer they are than the next; the
    // weights' sum is 1.
    struct Closest {
        size_t size = 0;
        std::array<std::uint32_t, 3> near{};
        std::array<double, 3> weight{};
    };
    static Closest closest_of(size_t i, const SamplesAround& around, const Neighbourhood& of) {
        std::array<float, 4> distance2;
        std::array<std::uint32_t, 4> near{};
        size_t n = 0;
        for (const std::uint32_t j : of.near) {
            if (around.place[j] == i) continue;
            const float here = of.distance2[j];
            size_t k = n < 4 ? n++ : 4;
            for (; k > 0 && here < distance2[k - 1]; --k)
                if (k < 4) distance2[k] = distance2[k - 1], near[k] = near[k - 1];
            if (k < 4) distance2[k] = here, near[k] = j;
        }
        Closest found;
        found.size = std::min<size_t>(3, n);
        if (n == 0) return found;
        const double far = std::sqrt(double(distance2[n - 1])) * (n == 4 ? 1 : 2);
        double sum = 0;
        for (size_t k = 0; k < found.size; ++k) {
            found.near[k] = near[k];
            found.weight[k] = far > 0 ? 1 - std::sqrt(double(distance2[k])) / far : 1;
            sum += found.weight[k];
        }
        for (double& weight : found.weight)
            weight = sum > 0 ? weight / sum : 1.0 / double(found.size);
        return found;
    }
    std::array<float, most_axes> place_of(size_t i) const {
        std::array<float, most_axes> at{};
        for (size_t d = 0; d < axes_; ++d) at[d] = tree_.at(d)[i];
        return at;
    }
    // Finds how far samples of a bucket look; first within `reach` of it, then farther. How far it
    // took.
    float measure(size_t bucket, float reach, Scratch& scratch) {
        gather(bucket, reach, scratch.of_bucket);
        for (size_t i = buckets_[bucket].first; i < buckets_[bucket].second; ++i) {
            const auto centre = place_of(i);
            while (!WEFT_PICK(find_neighbours)(scratch.of_bucket, axes_, centre.data(), nullptr,
                                               reach * reach, reached(), scratch.pooled)) {
                reach *= 1.3f;
                gather(bucket, reach, scratch.of_bucket);
            }
            within2_[i] = scratch.pooled.radius2;
        }
        return reach;
    }
    void gather(size_t bucket, float reach, SamplesAround& around) const {
        const auto [first, last] = buckets_[bucket];
        std::array<float, most_axes> lo{}, hi{};
        std::array<const float*, most_axes> at{};
        for (size_t d = 0; d < axes_; ++d) {
            at[d] = tree_.at(d).data();
            const auto [least, most] = std::minmax_element(at[d] + first, at[d] + last);
            lo[d] = *least, hi[d] = *most;
        }
        around.size = 0;
        const float reach2 = reach * reach;
        // Runs that follow each other as one.
        size_t begin = 0, end = 0;
        const auto take = [&] {
            WEFT_PICK(append_within)
            (at, nullptr, begin, end, axes_, lo.data(), hi.data(), reach2, around);
        };
        with_axes(axes_, [&](auto axes) {
            tree_.visit(
                [&](const float* from, const float* to, size_t) {
                    float off2 = 0;
                    for (size_t d = 0; d < axes.value; ++d) {
                        const float off = std::max(std::max(from[d] - hi[d], lo[d] - to[d]), 0.0f);
                        off2 += off * off;
                    }
                    return off2 <= reach2;
                },
                [&](size_t first_of_run, size_t end_of_run) {
                    if (first_of_run != end) {
                        take();
                        begin = first_of_run;
                    }
                    end = end_of_run;
                });
        });
        take();
    }

    const PointTree& tree_;
    const TensorSettings& settings_;
    size_t axes_;
    std::array<std::vector<float>, 3> channels_;
    std::array<const float*, 3> rgb_{};
    std::vector<std::pair<size_t, size_t>> buckets_;
    std::vector<float> within2_;  // of each sample: how far it looks
    bool known_ = false;          // whether that is found
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
    samples.around_each(ctx, [](size_t, Surroundings::Scratch&) {});
    return samples.supports();
}

Variation variation(const PointTree& tree, std::span<const float> rgb,
                    const TensorSettings& settings, Context& ctx) {
    const size_t n = tree.size(), axes = tree.dimensions(), numbers = axes * (axes + 1) / 2;
    Variation made;
    made.gradient.resize(3 * axes * n);
    made.least.resize(3 * n), made.most.resize(3 * n), made.radiance.resize(3 * n);
    made.upper.resize(numbers * n);
    std::vector<float> own(averaged_stride(axes) * n), next(own.size());
    Surroundings samples(tree, rgb, settings);
    const auto fit = [&](size_t i, const float* upper, Surroundings::Scratch& scratch,
                         std::vector<float>& tensors) {
        samples.find(i, upper, settings.neighbours + 1, scratch.of_sample, scratch.fitted);
        samples.fit(i, scratch.of_sample, scratch.fitted, made, tensors);
    };
    samples.around_each(
        ctx, [&](size_t i, Surroundings::Scratch& scratch) { fit(i, nullptr, scratch, own); });
    // Each round averages the tensors of the one before and fits anew by what that says is near.
    bool first = true, last = false;
    for (float floor = first_floor; !last; floor *= floor_of_round, first = false) {
        last = floor <= settings.floor * 1.001f || first_floor <= settings.floor;
        samples.around_each(ctx, [&](size_t i, Surroundings::Scratch& scratch) {
            float* upper = &made.upper[numbers * i];
            samples.find(i, first ? nullptr : upper, settings.averaged + 1, scratch.of_sample,
                         scratch.averaged);
            std::array<float, averaged_numbers(most_axes)> mean{};
            WEFT_PICK(mean_of_neighbours)
            (scratch.of_sample, own.data(), axes, scratch.averaged, mean.data());
            // Least squares of what is left when the closest ones go `part` of the way to the fit.
            // The nearer that is to all, the more of the gradients is noise as well, and distances
            // become round; only near to all, as fits to fine texture are poor, too.
            const float covariance = mean[numbers], variance = mean[numbers + 1];
            const float part = settings.smooth && variance > rounding
                                   ? std::clamp(covariance / variance, 0.0f, 1.0f)
                                   : 0.0f;
            const float rounder = std::pow(part, 8.0f);
            if (!last) {
                quick_metric(mean.data(), axes, std::max(floor, rounder), upper);
                fit(i, upper, scratch, next);
                return;
            }
            Matrix tensor{};
            size_t k = 0;
            for (size_t a = 0; a < axes; ++a)
                for (size_t b = a; b < axes; ++b, ++k)
                    tensor[a][b] = tensor[b][a] = double(mean[k]);
            metric_of(tensor, axes, std::max(settings.floor, rounder), upper);
            for (size_t c = 0; c < 3; ++c)
                made.radiance[3 * i + c] = rgb[3 * i + c] + part * made.radiance[3 * i + c];
        });
        std::swap(own, next);
    }
    made.supports = samples.supports();
    return made;
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
