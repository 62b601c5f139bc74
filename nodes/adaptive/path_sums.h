// Weighted samples of a moving filter, and how their paths lie about its middle, along the way of
// motion and aside from it. How they would lie if all of pixel and shutter were sampled is known;
// what those few lie otherwise is taken off by a regression of their values: polynomials of the
// path are exact, of third degree along it, however few samples there are.
// Source: the regression estimator of survey sampling (Cochran 1977, Ch. 7), with moments of box
// and shutter as its known means.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

namespace weft::adaptive {

class PathSums {
  public:
    static constexpr size_t terms = 4;  // s, aside, s^2 and s^3 less their means; s along the way
    // Samples, by their weights, that it takes for so many terms.
    static constexpr std::array<float, terms> least = {6, 6, 9, 12};

    // Mean of s^2 and s^3 that all of pixel and shutter would have; s from the middle.
    PathSums(double second, double third)
        : scale_(1 / std::sqrt(second)), third_(third * scale_ * scale_ * scale_) {}

    void add(double w, const float* color, double along, double aside) {
        const double s = along * scale_;
        const std::array<double, terms> term = {s, aside * scale_, s * s - 1, s * s * s - third_};
        weight_ += w, squares_ += w * w;
        for (size_t j = 0; j < terms; ++j) {
            const double by = w * term[j];
            of_[j] += by;
            for (size_t k = 0; k <= j; ++k) of_both_[j][k] += by * term[k];
            for (size_t c = 0; c < 3; ++c) rgb_by_[j][c] += by * double(color[c]);
        }
        for (size_t c = 0; c < 3; ++c) {
            rgb_[c] += w * double(color[c]);
            low_[c] = std::min(low_[c], color[c]), high_[c] = std::max(high_[c], color[c]);
        }
    }

    // Samples, by their weights; 0: none.
    double effective() const { return weight_ > 0 ? weight_ * weight_ / squares_ : 0; }
    // The mean that they would have if their terms' means were 0.
    std::array<double, 3> fitted() const {
        std::array<double, 3> out;
        for (size_t c = 0; c < 3; ++c) out[c] = rgb_[c] / weight_;
        size_t used = 0;
        while (used < terms && effective() >= double(least[used])) ++used;
        if (used == 0) return out;
        const std::array<double, terms> by = shares(used);
        for (size_t c = 0; c < 3; ++c) {
            const double mean = out[c];
            for (size_t j = 0; j < used; ++j)
                out[c] -= by[j] * (rgb_by_[j][c] - of_[j] * mean) / weight_;
            out[c] = std::clamp(out[c], double(low_[c]), double(high_[c]));
        }
        return out;
    }

  private:
    // Of each covariance of a value with a term, how much is to be taken off: C^-1 times the terms'
    // means, by L D L^T. A term that others make has no share.
    std::array<double, terms> shares(size_t used) const {
        double lower[terms][terms] = {}, pivot[terms] = {};
        std::array<double, terms> out = {};
        const auto mean = [&](size_t j) { return of_[j] / weight_; };
        for (size_t j = 0; j < used; ++j) {
            for (size_t k = 0; k <= j; ++k) {
                double rest = of_both_[j][k] / weight_ - mean(j) * mean(k);
                const double whole = rest;
                for (size_t i = 0; i < k; ++i) rest -= lower[j][i] * pivot[i] * lower[k][i];
                if (k < j)
                    lower[j][k] = pivot[k] > 0 ? rest / pivot[k] : 0;
                else
                    pivot[j] = rest > 1e-6 * whole ? rest : 0;
            }
            out[j] = mean(j);
            for (size_t i = 0; i < j; ++i) out[j] -= lower[j][i] * out[i];
        }
        for (size_t j = 0; j < used; ++j) out[j] = pivot[j] > 0 ? out[j] / pivot[j] : 0;
        for (size_t j = used; j-- > 0;)
            for (size_t i = j + 1; i < used; ++i) out[j] -= lower[i][j] * out[i];
        return out;
    }

    double scale_, third_;
    double weight_ = 0, squares_ = 0, rgb_[3] = {0, 0, 0};
    double of_[terms] = {}, of_both_[terms][terms] = {}, rgb_by_[terms][3] = {};
    float low_[3] = {INFINITY, INFINITY, INFINITY}, high_[3] = {-INFINITY, -INFINITY, -INFINITY};
};

}  // namespace weft::adaptive
