#include "adaptive/structure_tensors_kernel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "adaptive/neighbourhood_kernel.h"
#include "adaptive/with_axes.h"

namespace weft::adaptive {
namespace {

constexpr size_t buckets_in_piece = 64;
constexpr float rounding = 1e-10f;  // squares of differences, against brightness, that say nothing
constexpr double worth = 2;    // times better a long distance has to predict what outshines others
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

    // Whether radiance among them goes so far apart that a little of the brightest outshines the
    // darkest: what is mixed of them is no longer like any.
    bool outshines(size_t i, const SamplesAround& around, const Neighbourhood& near) const {
        bool any = false;
        for (size_t c = 0; c < 3; ++c) {
            float least = rgb_[c][i], most = least;
            for (const std::uint32_t j : near.near) {
                const float value = rgb_[c][around.place[j]];
                least = std::min(least, value), most = std::max(most, value);
            }
            any = any || outshine(least, most);
        }
        return any;
    }
    // Distance by place on the film, above all: another sample is within half a pixel there. The
    // diagonal of its matrix, for x and y and for each of the other axes.
    std::array<double, 2> local_of(size_t i) const {
        const double n = double(axes_);
        if (axes_ == 2) return {1, 1};
        const double ball = std::pow(std::numbers::pi, n / 2) / std::tgamma(n / 2 + 1);
        const double spacing = std::sqrt(double(within2_[i])) *
                               std::pow(ball / double(std::max<size_t>(1, reached())), 1 / n);
        const double film = std::max(1.0, 4 * spacing * spacing);
        return {film, std::pow(film, -2 / (n - 2))};
    }
    void local_metric(size_t i, float* upper) const {
        const auto diagonal = local_of(i);
        for (size_t a = 0; a < axes_; ++a)
            for (size_t b = a; b < axes_; ++b)
                *upper++ = a == b ? float(diagonal[a < 2 ? 0 : 1]) : 0.0f;
    }
    // How far a sample is from the one that is nearest by that one's metric, and from the nearest
    // by place: relative, squared.
    std::array<float, 2> predicted_off(size_t i, const SamplesAround& around,
                                       const Variation& made) const {
        const auto centre = place_of(i);
        const auto local = local_of(i);
        const size_t numbers = axes_ * (axes_ + 1) / 2;
        std::array<float, 2> least{3e38f, 3e38f};
        std::array<size_t, 2> nearest{i, i};
        for (size_t j = 0; j < around.size; ++j) {
            const size_t other = around.place[j];
            if (other == i) continue;
            std::array<float, most_axes> off{};
            float off2 = 0, by_place = 0, by_metric = 0;
            for (size_t d = 0; d < axes_; ++d) {
                off[d] = centre[d] - around.at[d][j];
                off2 += off[d] * off[d];
                by_place += float(local[d < 2 ? 0 : 1]) * off[d] * off[d];
            }
            if (off2 > made.supports.squared[other]) continue;
            const float* m = &made.upper[numbers * other];
            for (size_t a = 0; a < axes_; ++a) {
                by_metric += *m++ * off[a] * off[a];
                for (size_t b = a + 1; b < axes_; ++b) by_metric += 2 * *m++ * off[a] * off[b];
            }
            if (by_metric < least[0]) least[0] = by_metric, nearest[0] = other;
            if (by_place < least[1]) least[1] = by_place, nearest[1] = other;
        }
        const auto wrong = [&](size_t other) {
            float sum = 0;
            for (size_t c = 0; c < 3; ++c) {
                const float here = rgb_[c][i], there = rgb_[c][other];
                const float by = (there - here) / (std::max(std::min(here, there), 0.0f) + 0.1f);
                sum += by * by;
            }
            return sum;
        };
        return {wrong(nearest[0]), wrong(nearest[1])};
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
    std::vector<char> bright(n);  // samples that others outshine, or that outshine others
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
            if (!samples.outshines(i, scratch.of_sample, scratch.averaged)) return;
            metric_of(tensor, axes, std::max(settings.floor, first_floor), upper);
            bright[i] = 1;
            for (size_t c = 0; c < 3; ++c)
                made.radiance[3 * i + c] = made.least[3 * i + c] = made.most[3 * i + c] =
                    rgb[3 * i + c];
        });
        std::swap(own, next);
    }
    made.supports = samples.supports();
    // Where some outshine others, what is carried too far is seen at once: there, distances by what
    // varies are kept where they predict each sample from the others so much better than nearness
    // on the film does (cross-validation).
    if (std::find(bright.begin(), bright.end(), 1) == bright.end()) return made;
    std::vector<std::array<float, 2>> off(n);
    samples.around_each(
        ctx,
        [&](size_t i, Surroundings::Scratch& scratch) {
            off[i] = samples.predicted_off(i, scratch.of_sample, made);
        },
        &bright);
    samples.around_each(
        ctx,
        [&](size_t i, Surroundings::Scratch& scratch) {
            float* upper = &made.upper[numbers * i];
            samples.find(i, upper, settings.averaged + 1, scratch.of_sample, scratch.averaged);
            double by_metric = 0, by_place = 0;
            for (size_t k = 0; k < scratch.averaged.near.size(); ++k) {
                const auto& of = off[scratch.of_sample.place[scratch.averaged.near[k]]];
                by_metric += double(scratch.averaged.weight[k] * of[0]);
                by_place += double(scratch.averaged.weight[k] * of[1]);
            }
            bright[i] = by_place < worth * by_metric ? 2 : 1;
        },
        &bright);
    for (size_t i = 0; i < n; ++i)
        if (bright[i] == 2) samples.local_metric(i, &made.upper[numbers * i]);
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
