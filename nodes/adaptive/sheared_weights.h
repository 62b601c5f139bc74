// Closed forms of sheared filters: how much of a window a sample stands for, once it is slid along
// its slope and falls off with the way it was slid.
//   picture  the pixel's box is crossed for an interval of time, or seen from a rectangle of lens
//   shadow   a Gaussian across and one along, over a light of half extent A: see
//            gaussian_over_window()
// Source: Egan et al. 2009, Sec. 4; Egan et al. 2011, Sec. 4; the integrals are derived here.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace weft::adaptive {

struct Interval {
    float a, b;
    float length() const { return b - a; }
    bool empty() const { return !(a < b); }
    Interval in(Interval other) const { return {std::max(a, other.a), std::min(b, other.b)}; }
};

// The error function within 5e-7, from a table: a filter asks for it some hundred times a pixel.
class ErrorFunction {
  public:
    ErrorFunction() {
        for (size_t i = 0; i < at_.size(); ++i) at_[i] = float(std::erf(double(i) / steps));
    }
    float operator()(float x) const {
        const float place = std::min(end * steps - 1, std::abs(x) * steps);  // NaN: at the end
        const auto i = size_t(place);
        const float value = at_[i] + (at_[i + 1] - at_[i]) * (place - float(i));
        return x < 0 ? -value : value;
    }

  private:
    static constexpr float steps = 512, end = 4;
    std::array<float, size_t(steps* end) + 1> at_;
};
// Its table is made when it is first asked for, not when the program starts.
inline const ErrorFunction& error_function() {
    static const ErrorFunction table;
    return table;
}

// Where in [lo, hi] a sample at `at`, `offset` from the middle of a box, lies within `half` of that
// middle, when it moves by `speed` a unit: offset + speed (s - at).
class InsideBox {
  public:
    InsideBox(float speed, float half)
        : still_(std::abs(speed) < 1e-6f),
          half_(half),
          inverse_(1 / speed),
          reach_(std::abs(half * inverse_)) {}
    Interval operator()(float offset, float at, float lo, float hi) const {
        if (still_) return std::abs(offset) <= half_ ? Interval{lo, hi} : Interval{hi, lo};
        const float middle = at - offset * inverse_;
        return {std::max(lo, middle - reach_), std::min(hi, middle + reach_)};
    }

  private:
    bool still_;
    float half_, inverse_, reach_;
};
inline Interval inside_box(float offset, float speed, float half, float at, float lo, float hi) {
    return InsideBox(speed, half)(offset, at, lo, hi);
}

// Integral of exp(-(s - at)^2 / (2 sigma^2)) from some place to s, in units that do not matter; the
// way itself where sigma is infinite. What lies in an interval is the difference of its ends.
class GaussianMass {
  public:
    GaussianMass(float at, float sigma)
        : at_(at),
          height_(sigma < INFINITY ? sigma * 1.2533141f : 0),
          scale_(1 / (sigma * std::numbers::sqrt2_v<float>)),
          erf_(error_function()) {}
    float operator()(float s) const { return height_ > 0 ? height_ * erf_((s - at_) * scale_) : s; }
    float in(Interval over) const { return (*this)(over.b) - (*this)(over.a); }
    GaussianMass around(float at) const {
        GaussianMass out = *this;
        out.at_ = at;
        return out;
    }

  private:
    float at_, height_, scale_;
    const ErrorFunction& erf_;
};
inline float gaussian_over(Interval over, float at, float sigma) {
    return GaussianMass(at, sigma).in(over);
}

// Area of the unit disc within [0, x] x [0, y], signed as x y.
inline float disc_corner(float x, float y) {
    const float sign = (x < 0) != (y < 0) ? -1.0f : 1.0f;
    x = std::min(std::abs(x), 1.0f), y = std::min(std::abs(y), 1.0f);
    if (x * x + y * y <= 1) return sign * x * y;
    const auto below = [](float s) {  // under the circle, up to s
        return 0.5f * (s * std::sqrt(std::max(0.0f, 1 - s * s)) + std::asin(s));
    };
    const float flat = std::sqrt(std::max(0.0f, 1 - y * y));
    return sign * (flat * y + below(x) - below(flat));
}
// Of a rectangle, the share that lies on the unit disc.
inline float share_on_disc(Interval x, Interval y) {
    const float farthest_x = std::max(std::abs(x.a), std::abs(x.b)),
                farthest_y = std::max(std::abs(y.a), std::abs(y.b));
    if (farthest_x * farthest_x + farthest_y * farthest_y <= 1) return 1;
    const float nearest_x = std::clamp(0.0f, x.a, x.b), nearest_y = std::clamp(0.0f, y.a, y.b);
    if (nearest_x * nearest_x + nearest_y * nearest_y >= 1) return 0;
    const float area = disc_corner(x.b, y.b) - disc_corner(x.a, y.b) - disc_corner(x.b, y.a) +
                       disc_corner(x.a, y.a);
    return std::clamp(area / (x.length() * y.length()), 0.0f, 1.0f);
}

// A Gaussian across (sigma x) and one along (sigma y), for a sample at light coordinate Y, D from
// the receiver, slid along slope s to every point of the light: the integrand over the light is
//     exp(-falloff) exp(-a (y - middle)^2 / 2).
struct ShearedGaussian {
    double a, middle, falloff;
    ShearedGaussian(double D, double Y, double sigma_x, double sigma_y, double s)
        : a(s * s / (sigma_x * sigma_x) + 1 / (sigma_y * sigma_y)),
          middle(Y + s * D / (sigma_x * sigma_x * a)),
          falloff(D * D / (2 * (sigma_x * sigma_x + s * s * sigma_y * sigma_y))) {}
};
// Its integral over the light, [-A, A].
inline double gaussian_over_window(double D, double Y, double sigma_x, double sigma_y, double s,
                                   double A) {
    const ShearedGaussian g(D, Y, sigma_x, sigma_y, s);
    const double root = std::sqrt(g.a / 2);
    return std::exp(-g.falloff) * std::sqrt(2 * std::numbers::pi / g.a) *
           (std::erf((A - g.middle) * root) + std::erf((A + g.middle) * root)) / 2;
}

}  // namespace weft::adaptive
