// Pixel filters: how much a sample counts for a pixel, by its distance from the pixel's centre. All
// are even and separable: the weight of a sample at (dx, dy) is evaluate(dx) * evaluate(dy). None
// is normalised; who filters divides by the sum of weights.
//   d         distance along one axis, px
//   evaluate  zero for |d| past `radius` (half the filter's width); may be negative for the last
//   two
// Source: Mitchell and Netravali 1988; Duchon 1979 (Lanczos' window); Harris 1978; the Gaussian
// less its value at the radius, so that it ends without a step (Pharr, Jakob and Humphreys, 4th
// edition).
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <variant>
#include <vector>

namespace weft {

struct BoxFilter {
    float radius = 0.5f;
    // Half open, so that boxes one pixel wide share no sample.
    float evaluate(float d) const { return d >= -radius && d < radius ? 1.0f : 0.0f; }
};

struct TentFilter {
    float radius = 1;
    float evaluate(float d) const { return std::max(0.0f, 1 - std::fabs(d) / radius); }
};

struct GaussianFilter {
    float radius = 1.5f;
    float sigma = 0.5f;  // standard deviation, px
    float evaluate(float d) const {
        if (std::fabs(d) >= radius) return 0;
        const float k = -0.5f / (sigma * sigma);
        return std::exp(k * d * d) - std::exp(k * radius * radius);
    }
};

// The cubics of Mitchell and Netravali, stretched to the radius. (1/3, 1/3) is their own choice,
// (1, 0) the cubic B-spline, (0, 1/2) Catmull-Rom.
struct MitchellFilter {
    float radius = 2;
    float b = 1.0f / 3, c = 1.0f / 3;
    float evaluate(float d) const {
        const float x = 2 * std::fabs(d) / radius;
        if (x >= 2) return 0;
        if (x < 1)
            return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x +
                    (6 - 2 * b)) /
                   6;
        return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x +
                (8 * b + 24 * c)) /
               6;
    }
};

// sinc(d) under the middle lobe of sinc(d / tau).
struct LanczosFilter {
    float radius = 3;
    float tau = 3;  // where the window ends, px; at the radius there is no step
    float evaluate(float d) const {
        const float x = std::fabs(d);
        if (x >= radius || x >= tau) return 0;
        return sinc(x) * sinc(x / tau);
    }
    static float sinc(float x) {
        const float s = std::numbers::pi_v<float> * x;
        return s < 1e-4f ? 1.0f : std::sin(s) / s;
    }
};

// Four terms, side lobes of the spectrum below -92 dB.
struct BlackmanHarrisFilter {
    float radius = 1.5f;
    float evaluate(float d) const {
        if (std::fabs(d) >= radius) return 0;
        const float s = std::numbers::pi_v<float> * (d / radius);
        return 0.35875f + 0.48829f * std::cos(s) + 0.14128f * std::cos(2 * s) +
               0.01168f * std::cos(3 * s);
    }
};

using PixelFilter = std::variant<BoxFilter, TentFilter, GaussianFilter, MitchellFilter,
                                 LanczosFilter, BlackmanHarrisFilter>;

inline float radius_of(const PixelFilter& filter) {
    return std::visit([](const auto& f) { return f.radius; }, filter);
}
inline float evaluate(const PixelFilter& filter, float d) {
    return std::visit([d](const auto& f) { return f.evaluate(d); }, filter);
}
// A box as wide as a pixel: each sample counts fully, for its own pixel.
inline bool is_pixel_box(const PixelFilter& filter) {
    const auto* box = std::get_if<BoxFilter>(&filter);
    return box && box->radius == 0.5f;
}

// As a node's parameters name them. A width of 0 is the filter's own.
enum class FilterKind { box, tent, gaussian, mitchell, lanczos, blackman_harris };
inline std::vector<std::string> filter_names() {
    return {"box", "tent", "gaussian", "mitchell", "lanczos", "blackman-harris"};
}
struct FilterChoice {
    FilterKind kind = FilterKind::box;
    float width = 0;
    float sigma = 0.5f, b = 1.0f / 3, c = 1.0f / 3, tau = 3;
};
inline PixelFilter make_filter(const FilterChoice& choice) {
    const auto sized = [&](auto filter) -> PixelFilter {
        if (choice.width > 0) filter.radius = 0.5f * choice.width;
        return filter;
    };
    switch (choice.kind) {
        case FilterKind::tent:
            return sized(TentFilter{});
        case FilterKind::gaussian:
            return sized(GaussianFilter{.sigma = choice.sigma});
        case FilterKind::mitchell:
            return sized(MitchellFilter{.b = choice.b, .c = choice.c});
        case FilterKind::lanczos:
            return sized(LanczosFilter{.tau = choice.tau});
        case FilterKind::blackman_harris:
            return sized(BlackmanHarrisFilter{});
        case FilterKind::box:
            break;
    }
    return sized(BoxFilter{});
}

}  // namespace weft
