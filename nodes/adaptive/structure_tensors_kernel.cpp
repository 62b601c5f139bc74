#include "adaptive/structure_tensors_kernel.h"

#include <algorithm>
#include <cmath>

#include "adaptive/surroundings.h"

namespace weft::adaptive {
namespace {

constexpr float rounding = 1e-10f;  // squares of differences, against brightness, that say nothing
constexpr double worth = 2;  // times better a long distance has to predict what outshines others
constexpr size_t fitted_in_noise = 2;  // times as many as are fitted to without
// What outshines others does so by chance where radiance goes farther than this on the way to the
// fit, and less than this of it is explained by a plane.
constexpr float mostly_noise = 0.5f;
constexpr double of_noise = 0.2;

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
    const size_t fitted = settings.neighbours * (settings.smooth ? fitted_in_noise : 1);
    const auto fit = [&](size_t i, const float* upper, Surroundings::Scratch& scratch,
                         std::vector<float>& tensors) {
        samples.find(i, upper, fitted + 1, scratch.of_sample, scratch.fitted);
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
            if (!samples.outshines(i, scratch.of_sample, scratch.averaged) ||
                (part > mostly_noise &&
                 samples.explained(i, scratch.of_sample, scratch.averaged) < of_noise))
                return;
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
