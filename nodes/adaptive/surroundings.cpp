#include "adaptive/surroundings.h"

#include <numbers>

#include "adaptive/with_axes.h"

namespace weft::adaptive {
namespace {

constexpr size_t pool_of = 2;  // times as many as are averaged are looked at

}  // namespace

Surroundings::Surroundings(const PointTree& tree, std::span<const float> rgb,
                           const TensorSettings& settings)
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

void Surroundings::find(size_t i, const float* upper, size_t count, const SamplesAround& around,
                        Neighbourhood& found) const {
    WEFT_PICK(find_neighbours)
    (around, axes_, place_of(i).data(), upper, within2_[i], std::min(count, tree_.size()), found);
}

void Surroundings::fit(size_t i, const SamplesAround& around, Neighbourhood& near, Variation& made,
                       std::vector<float>& tensors) const {
    const auto centre = place_of(i);
    const NeighbourSums sums = sums_of(i, around, near);
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
    const Matrix squares = factored_squares(sums, near);
    const Closest closest = closest_of(i, around, near);
    // How much of the fit at the sample's place is its own doing; its weight is 1.
    std::array<double, most_axes> middle{};
    for (size_t a = 0; a < axes_; ++a) middle[a] = double(sums.d[a]) / w;
    const auto turned = solve_factored(squares, axes_, middle);
    double own_part = 1 / w;
    for (size_t a = 0; a < axes_; ++a) own_part += middle[a] * turned[a];
    const double others = std::max(1 - own_part, 1e-3);
    for (size_t c = 0; c < 3; ++c) {
        const auto slope = solve_factored(squares, axes_, moments_of(sums, c));
        const double level = level_of(rgb_[c][i], double(sums.f[c]) / w);
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

bool Surroundings::outshines(size_t i, const SamplesAround& around,
                             const Neighbourhood& near) const {
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

double Surroundings::explained(size_t i, const SamplesAround& around, Neighbourhood& near) const {
    const NeighbourSums sums = sums_of(i, around, near);
    const Matrix squares = factored_squares(sums, near);
    double all = 0, by_plane = 0;
    for (size_t c = 0; c < 3; ++c) {
        const double mean = double(sums.f[c]) / double(sums.w), level = level_of(rgb_[c][i], mean);
        for (size_t n = 0; n < near.near.size(); ++n) {
            const double value = double(rgb_[c][around.place[near.near[n]]]),
                         off = (value - double(rgb_[c][i]) - mean) / level;
            all += double(near.weight[n]) * off * off;
        }
        const auto moments = moments_of(sums, c), slope = solve_factored(squares, axes_, moments);
        for (size_t a = 0; a < axes_; ++a) by_plane += slope[a] * moments[a] / (level * level);
    }
    return all > 0 ? by_plane / all : 1;
}

std::array<float, 2> Surroundings::predicted_off(size_t i, const SamplesAround& around,
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

void Surroundings::local_metric(size_t i, float* upper) const {
    const auto diagonal = local_of(i);
    for (size_t a = 0; a < axes_; ++a)
        for (size_t b = a; b < axes_; ++b)
            *upper++ = a == b ? float(diagonal[a < 2 ? 0 : 1]) : 0.0f;
}

Supports Surroundings::supports() const {
    const double part =
        double(std::min(samples_in_support, tree_.size())) / double(std::max<size_t>(1, reached()));
    const float share = float(std::pow(part, 2 / double(axes_)));
    Supports made;
    for (const float squared : within2_) made.squared.push_back(share * squared);
    made.of_node = tree_.largest(made.squared);
    return made;
}

size_t Surroundings::reached() const {
    return std::min(tree_.size(), pool_of * std::max(settings_.averaged, settings_.neighbours) + 1);
}

std::array<double, 2> Surroundings::local_of(size_t i) const {
    const double n = double(axes_);
    if (axes_ == 2) return {1, 1};
    const double ball = std::pow(std::numbers::pi, n / 2) / std::tgamma(n / 2 + 1);
    const double spacing = std::sqrt(double(within2_[i])) *
                           std::pow(ball / double(std::max<size_t>(1, reached())), 1 / n);
    const double film = std::max(1.0, 4 * spacing * spacing);
    return {film, std::pow(film, -2 / (n - 2))};
}

Surroundings::Closest Surroundings::closest_of(size_t i, const SamplesAround& around,
                                               const Neighbourhood& of) {
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
    for (double& weight : found.weight) weight = sum > 0 ? weight / sum : 1.0 / double(found.size);
    return found;
}

NeighbourSums Surroundings::sums_of(size_t i, const SamplesAround& around,
                                    Neighbourhood& near) const {
    return WEFT_PICK(sum_neighbours)(around, axes_, place_of(i).data(), rgb_, std::uint32_t(i),
                                     near);
}

Matrix Surroundings::factored_squares(const NeighbourSums& sums, const Neighbourhood& of) const {
    Matrix squares{};
    size_t k = 0;
    for (size_t a = 0; a < axes_; ++a)
        for (size_t b = a; b < axes_; ++b, ++k)
            squares[b][a] =
                double(sums.dd[k]) - double(sums.d[a]) * double(sums.d[b]) / double(sums.w);
    for (size_t a = 0; a < axes_; ++a)
        squares[a][a] += double(settings_.ridge) * double(of.radius2);
    factor(squares, axes_);
    return squares;
}

std::array<double, most_axes> Surroundings::moments_of(const NeighbourSums& sums,
                                                       size_t channel) const {
    std::array<double, most_axes> moments{};
    for (size_t a = 0; a < axes_; ++a)
        moments[a] = double(sums.df[channel * axes_ + a]) -
                     double(sums.d[a]) * double(sums.f[channel]) / double(sums.w);
    return moments;
}

double Surroundings::level_of(float radiance, double mean_off) {
    return std::max(double(radiance) + mean_off, 0.0) + 0.1;
}

std::array<float, most_axes> Surroundings::place_of(size_t i) const {
    std::array<float, most_axes> at{};
    for (size_t d = 0; d < axes_; ++d) at[d] = tree_.at(d)[i];
    return at;
}

float Surroundings::measure(size_t bucket, float reach, Scratch& scratch) {
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

void Surroundings::gather(size_t bucket, float reach, SamplesAround& around) const {
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

}  // namespace weft::adaptive
