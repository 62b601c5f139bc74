#include "adaptive/lens_pieces.h"

#include <numbers>

namespace weft::adaptive {

namespace {

std::array<double, 2> corner(const Lens& lens, int k) {
    const double angle = double(lens.rotation) + 2 * std::numbers::pi * k / lens.blades;
    return {std::cos(angle), std::sin(angle)};
}

// Where the outline lies over u.
Interval outline(const Lens& lens, double u) {
    if (lens.blades < 3) {
        const auto half = float(std::sqrt(std::max(0.0, 1 - u * u)));
        return {-half, half};
    }
    Interval out{INFINITY, -INFINITY};
    for (int k = 0; k < lens.blades; ++k) {
        const auto a = corner(lens, k), b = corner(lens, k + 1);
        if (std::min(a[0], b[0]) > u || std::max(a[0], b[0]) < u || a[0] == b[0]) continue;
        const auto v = float(a[1] + (b[1] - a[1]) * (u - a[0]) / (b[0] - a[0]));
        out.a = std::min(out.a, v), out.b = std::max(out.b, v);
    }
    return out;
}

// Sums over an area, of which the means and variances of u and v are.
struct Moments {
    double area = 0, u = 0, uu = 0, v = 0, vv = 0;
    void add(double at, double low, double high) {  // a strip of unit width
        const double height = high - low;
        area += height, u += height * at, uu += height * at * at;
        v += (high * high - low * low) / 2, vv += (std::pow(high, 3) - std::pow(low, 3)) / 3;
    }
    double mean_u() const { return u / area; }
    double mean_v() const { return v / area; }
    double deviation_u() const { return std::sqrt(uu / area - mean_u() * mean_u()); }
    double deviation_v() const { return std::sqrt(vv / area - mean_v() * mean_v()); }
};

// From left to right.
Interval extent(const Lens& lens) {
    if (lens.blades < 3) return {-1, 1};
    Interval out{INFINITY, -INFINITY};
    for (int k = 0; k < lens.blades; ++k) {
        const auto u = float(corner(lens, k)[0]);
        out.a = std::min(out.a, u), out.b = std::max(out.b, u);
    }
    return out;
}

}  // namespace

LensPieces::LensPieces(const Lens& lens, size_t count) : columns(count) {
    const size_t steps = 1024 / count;
    const Interval over = extent(lens);
    const double step = double(over.length()) / double(count * steps);
    const auto place = [&](size_t s) { return double(over.a) + (double(s) + 0.5) * step; };
    Moments whole, pieces;
    for (size_t k = 0; k < count; ++k) {
        double low = 0, high = 0;
        for (size_t s = k * steps; s < (k + 1) * steps; ++s) {
            const Interval at = outline(lens, place(s));
            if (at.empty()) continue;
            low += double(at.a), high += double(at.b);
            whole.add(place(s), double(at.a), double(at.b));
        }
        low /= double(steps), high /= double(steps);
        v[k] = {float(low), float(high)};
        for (size_t s = k * steps; s < (k + 1) * steps; ++s) pieces.add(place(s), low, high);
    }
    const double stretch_u = whole.deviation_u() / pieces.deviation_u(),
                 stretch_v = whole.deviation_v() / pieces.deviation_v();
    const auto moved = [&](float at) {
        return float(whole.mean_v() + (double(at) - pieces.mean_v()) * stretch_v);
    };
    for (size_t k = 0; k < count; ++k) v[k] = {moved(v[k].a), moved(v[k].b)};
    first = float(whole.mean_u() + (double(over.a) - pieces.mean_u()) * stretch_u);
    width = float(double(over.length()) * stretch_u / double(count));
    per_unit = 1 / width;
}

}  // namespace weft::adaptive
