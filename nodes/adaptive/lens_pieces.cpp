#include "adaptive/lens_pieces.h"

#include <numbers>

namespace weft::adaptive {

namespace {

// Where the outline lies over u.
Interval outline(const Lens& lens, double u) {
    if (lens.blades < 3) {
        const auto half = float(std::sqrt(std::max(0.0, 1 - u * u)));
        return {-half, half};
    }
    Interval out{INFINITY, -INFINITY};
    const auto corner = [&](int k) {
        const double angle = double(lens.rotation) + 2 * std::numbers::pi * k / lens.blades;
        return std::array{std::cos(angle), std::sin(angle)};
    };
    for (int k = 0; k < lens.blades; ++k) {
        const auto a = corner(k), b = corner(k + 1);
        if (std::min(a[0], b[0]) > u || std::max(a[0], b[0]) < u || a[0] == b[0]) continue;
        const auto v = float(a[1] + (b[1] - a[1]) * (u - a[0]) / (b[0] - a[0]));
        out.a = std::min(out.a, v), out.b = std::max(out.b, v);
    }
    return out;
}

}  // namespace

LensPieces::LensPieces(const Lens& lens) {
    constexpr int steps = 256;
    for (size_t k = 0; k < lens_columns; ++k) {
        double low = 0, high = 0;
        for (int s = 0; s < steps; ++s) {
            const Interval at = outline(lens, (double(k) + (s + 0.5) / steps) * double(width) - 1);
            if (!at.empty()) low += double(at.a), high += double(at.b);
        }
        v[k] = {float(low / steps), float(high / steps)};
    }
}

}  // namespace weft::adaptive
