#include <algorithm>
#include <cmath>

#include "filters/similarity.h"

namespace weft::kernel {
namespace {

struct At {
    int x, y;
};
At operator+(At a, At b) {
    return {a.x + b.x, a.y + b.y};
}

double value(const Planes& planes, int plane, At p) {
    return double(planes.row(plane, p.y)[p.x]);
}

bool known(const Similarity& by, At p) {
    return p.x >= 0 && p.y >= 0 && p.x < by.planes.width && p.y < by.planes.height &&
           value(by.planes, by.known, p) > 0;
}

double let_pass(const Planes& planes, const Term& term, At p) {
    if (term.slope < 0) return double(term.e);
    return std::max(double(term.e), double(term.slope_gain) * value(planes, term.slope, p));
}

double over_noise(const Term& term, double difference, double va, double vb, double e) {
    return (difference - double(term.subtract) * (va + std::min(va, vb))) /
           (e + double(term.k2) * (va + vb));
}

double squared_difference(const Planes& planes, int plane, At p, At q) {
    return std::pow(value(planes, plane, p) - value(planes, plane, q), 2);
}

double vector_distance(const Planes& planes, const Term& term, At p, At q) {
    double difference = 0, va = 0, vb = 0;
    for (int c = 0; c < term.components; ++c)
        difference += squared_difference(planes, term.first + c, p, q);
    for (int c = 0; term.variances >= 0 && c < term.variance_planes; ++c) {
        va += value(planes, term.variances + c, p);
        vb += value(planes, term.variances + c, q);
    }
    return over_noise(term, difference, va, vb, let_pass(planes, term, p));
}

double color_distance(const Similarity& by, At p, At q) {
    const Planes& planes = by.planes;
    const Term& color = by.color;
    if (!by.apart) return vector_distance(planes, color, p, q);
    double sum = 0;
    for (int c = 0; c < color.components; ++c) {
        const bool noisy = color.variances >= 0;
        sum += over_noise(color, squared_difference(planes, color.first + c, p, q),
                          noisy ? value(planes, color.variances + c, p) : 0,
                          noisy ? value(planes, color.variances + c, q) : 0, double(color.e));
    }
    return sum / color.components;
}

double patch_distance(const Similarity& by, At p, At q) {
    double sum = 0;
    int count = 0;
    for (int j = -by.patch; j <= by.patch; ++j)
        for (int i = -by.patch; i <= by.patch; ++i) {
            const At a = p + At{i, j}, b = q + At{i, j};
            if (!known(by, a) || !known(by, b)) continue;
            sum += color_distance(by, a, b);
            ++count;
        }
    return count > 0 ? sum / count : 0;
}

}  // namespace

int output_planes(const Similarity& by) {
    return by.channels + (by.variances >= 0 ? by.color.components : 0) + 1;
}

void similar_mean(const Similarity& by, int x, int y, double* out) {
    const At p{x, y};
    const int planes = output_planes(by);
    std::fill_n(out, planes, 0.0);
    double& total = out[planes - 1];
    for (const Tap& tap : by.taps) {
        const At q = p + At{tap.dx, tap.dy};
        if (!known(by, q)) continue;
        double exponent = by.color.components > 0 ? std::max(0.0, patch_distance(by, p, q)) : 0.0;
        for (const Term& feature : by.features)
            exponent += std::max(0.0, vector_distance(by.planes, feature, p, q));
        const double w = double(tap.weight) * std::exp(-std::min(exponent, double(last_exponent)));
        total += w;
        for (int c = 0; c < by.channels; ++c) out[c] += w * value(by.planes, c, q);
        if (by.variances >= 0)
            for (int c = 0; c < by.color.components; ++c)
                out[by.channels + c] += w * w * value(by.planes, by.variances + c, q);
    }
    if (!(total > 0)) return;
    for (int c = 0; c < by.channels; ++c) out[c] /= total;
    for (int c = by.channels; c < planes - 1; ++c) out[c] /= total * total;
}

}  // namespace weft::kernel
