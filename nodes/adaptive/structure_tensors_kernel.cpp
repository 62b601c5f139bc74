#include "adaptive/structure_tensors_kernel.h"

#include <algorithm>
#include <cmath>

namespace weft::adaptive {
namespace {

constexpr size_t samples_in_piece = 1024;

// work(place, neighbours nearest first) for each sample, its own among them.
template <class Work>
void around_each(const PointTree& tree, size_t neighbours, Context& ctx, Work&& work) {
    ctx.parallel(tree.size(), samples_in_piece, [&](size_t begin, size_t end) {
        std::vector<PointTree::Near> near;
        std::array<float, most_axes> at{};
        for (size_t i = begin; i < end; ++i) {
            for (size_t d = 0; d < tree.dimensions(); ++d) at[d] = tree.at(d)[i];
            tree.nearest(at.data(), neighbours + 1, near);
            work(i, near);
        }
    });
}
double weight(const PointTree::Near& near, const std::vector<PointTree::Near>& all) {
    const double farthest = double(all.back().distance2);
    return farthest > 0 ? std::exp(-2 * double(near.distance2) / farthest) : 1.0;
}

}  // namespace

std::vector<float> gradients(const PointTree& tree, std::span<const float> rgb,
                             const TensorSettings& settings, Context& ctx) {
    const size_t axes = tree.dimensions();
    std::vector<float> result(3 * axes * tree.size());
    around_each(tree, settings.neighbours, ctx, [&](size_t i, const auto& near) {
        Matrix squares{};
        std::array<std::array<double, most_axes>, 3> slopes{};
        std::array<double, most_axes> middle{};
        std::array<double, 3> mean{};
        double total = 0;
        for (const PointTree::Near& n : near) {
            const double w = weight(n, near);
            total += w;
            for (size_t d = 0; d < axes; ++d)
                middle[d] += w * (double(tree.at(d)[n.place]) - double(tree.at(d)[i]));
            for (size_t c = 0; c < 3; ++c)
                mean[c] += w * (double(rgb[3 * size_t(n.place) + c]) - double(rgb[3 * i + c]));
        }
        for (double& m : middle) m /= total;
        for (double& m : mean) m /= total;
        for (const PointTree::Near& n : near) {
            const double w = weight(n, near);
            std::array<double, most_axes> off{};
            for (size_t d = 0; d < axes; ++d)
                off[d] = double(tree.at(d)[n.place]) - double(tree.at(d)[i]) - middle[d];
            for (size_t a = 0; a < axes; ++a)
                for (size_t b = 0; b <= a; ++b) squares[a][b] += w * off[a] * off[b];
            for (size_t c = 0; c < 3; ++c) {
                const double change =
                    double(rgb[3 * size_t(n.place) + c]) - double(rgb[3 * i + c]) - mean[c];
                for (size_t d = 0; d < axes; ++d) slopes[c][d] += w * off[d] * change;
            }
        }
        const double radius2 = double(near.back().distance2);
        if (!(radius2 > 0)) return;  // all in one place: nothing is known, and 0 says so
        for (size_t a = 0; a < axes; ++a) squares[a][a] += double(settings.ridge) * radius2;
        for (size_t c = 0; c < 3; ++c) {
            solve(squares, axes, slopes[c]);
            for (size_t d = 0; d < axes; ++d) result[(3 * i + c) * axes + d] = float(slopes[c][d]);
        }
    });
    return result;
}

std::vector<float> structure_metrics(const PointTree& tree, std::span<const float> rgb,
                                     std::span<const float> gradients,
                                     const TensorSettings& settings, Context& ctx) {
    const size_t axes = tree.dimensions(), numbers = axes * (axes + 1) / 2;
    std::vector<float> upper(numbers * tree.size());
    around_each(tree, settings.neighbours, ctx, [&](size_t i, const auto& near) {
        double total = 0;
        std::array<double, 3> mean{};
        for (const PointTree::Near& n : near) {
            const double w = weight(n, near);
            total += w;
            for (size_t c = 0; c < 3; ++c) mean[c] += w * double(rgb[3 * size_t(n.place) + c]);
        }
        Matrix tensor{};
        for (const PointTree::Near& n : near) {
            const double w = weight(n, near);
            for (size_t c = 0; c < 3; ++c) {
                // Against brightness, as the eye sees it: without it, dark places would vary least.
                const double level = std::max(mean[c] / total, 0.0) + 0.1;
                const float* g = &gradients[(3 * size_t(n.place) + c) * axes];
                for (size_t a = 0; a < axes; ++a)
                    for (size_t b = a; b < axes; ++b)
                        tensor[a][b] += w / (total * level * level) * double(g[a]) * double(g[b]);
            }
        }
        for (size_t a = 0; a < axes; ++a)
            for (size_t b = 0; b < a; ++b) tensor[a][b] = tensor[b][a];
        metric_of(tensor, axes, settings.floor, &upper[numbers * i]);
    });
    return upper;
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
