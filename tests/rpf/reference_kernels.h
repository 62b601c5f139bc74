// What the kernels of random parameter filtering must give, written down as defined, in double.
#pragma once
#include <algorithm>
#include <cmath>

#include "rpf/kernels.h"

namespace weft::rpf::reference {

inline std::vector<std::uint32_t> accept(const SampleVectors& v,
                                         const std::vector<std::uint32_t>& candidates,
                                         const float* centre, const float* bound) {
    std::vector<std::uint32_t> accepted;
    for (const std::uint32_t i : candidates) {
        bool inside = true;
        for (size_t k = 0; k < v.components.size(); ++k)
            inside &= std::abs(v.of(i)[k] - centre[k]) <= bound[k];
        if (inside) accepted.push_back(i);
    }
    return accepted;
}

// The color of own sample i.
inline std::array<double, 3> filter(const Neighbourhoods& n, const Weights& w, const float* rgb,
                                    const Likeness& by, size_t i) {
    double total = 0;
    std::array<double, 3> sum{};
    for (size_t j = 0; j < n.samples(); ++j) {
        double features = 0, colors = 0;
        for (size_t k = 0; k < n.rows(); ++k) {
            const double d = (double(n.row(k)[i]) - double(n.row(k)[j])) * double(n.scale[k]);
            (k < n.color_row(0) ? features : colors) +=
                double(w.of_row[k]) * double(by.scale) * d * d;
        }
        if (features >= double(by.cutoff) || colors >= double(by.cutoff)) continue;
        const double weight = std::exp(-features - colors);
        total += weight;
        for (size_t c = 0; c < 3; ++c) sum[c] += weight * double(rgb[3 * size_t(n.sample[j]) + c]);
    }
    for (double& c : sum) c /= total;
    return sum;
}

// The weight of pixel (x + dx, y + dy) for pixel (x, y).
inline double weigh_pixel(const SampleVectors& v, const Weights& w, const PixelLikeness& by, int x,
                          int y, int dx, int dy) {
    const PixelStatistics& p = v.pixels;
    const auto there = [&](int a, int b) {
        return a >= 0 && b >= 0 && a < p.planes.width && b < p.planes.height &&
               p.planes.row(p.samples(), b)[a] > 0;
    };
    const auto at = [&](int plane, int a, int b) { return double(p.planes.row(plane, b)[a]); };
    if (!there(x, y) || !there(x + dx, y + dy)) return 0;
    const auto distance = [](double square, double va, double vb, double k, double e) {
        return (square - va - std::min(va, vb)) / (e + k * k * (va + vb));
    };
    double color = 0, known = 0;
    for (int b = y - 1; b <= y + 1; ++b)
        for (int a = x - 1; a <= x + 1; ++a) {
            if (!there(a, b) || !there(a + dx, b + dy)) continue;
            known += 1;
            for (size_t c = 0; c < 3; ++c) {
                const double d = at(p.color(c), a, b) - at(p.color(c), a + dx, b + dy);
                color += distance(d * d, at(p.color_noise(c), a, b),
                                  at(p.color_noise(c), a + dx, b + dy), double(by.k_color), 1e-10) /
                         3;
            }
        }
    const size_t row = v.components.size();
    double sum = double(w.of_row[row] + w.of_row[row + 1] + w.of_row[row + 2]) / 3 *
                 std::max(0.0, color / std::max(1.0, known));
    for (size_t g = 0; g < p.groups.size(); ++g) {
        double square = 0, beta = 0;
        for (size_t k = p.groups[g].begin; k < p.groups[g].end; ++k) {
            const double d = at(p.mean(k), x, y) - at(p.mean(k), x + dx, y + dy);
            square += d * d;
            beta += double(w.of_row[k]) / double(p.groups[g].end - p.groups[g].begin);
        }
        const double e = std::max(
            {1e-30, 2 * double(by.least) * double(by.least) * double(p.groups[g].deviation2),
             2 * double(by.slope) * double(by.slope) * at(p.slope(g), x, y)});
        sum += beta *
               std::max(0.0, distance(square, at(p.noise(g), x, y), at(p.noise(g), x + dx, y + dy),
                                      double(by.k_features), e));
    }
    return std::exp(-double(dx * dx + dy * dy) / (2 * double(by.sigma) * double(by.sigma)) -
                    std::min(sum, 80.0));
}

}  // namespace weft::rpf::reference
