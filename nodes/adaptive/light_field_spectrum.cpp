#include "adaptive/light_field_spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace weft::adaptive {

LightFieldWindow light_field_window(std::span<const WindowPoint> points, int width, double px,
                                    int height, double extent) {
    LightFieldWindow out{width, height, px / width, extent / height, {}};
    const auto w = size_t(width), h = size_t(height);
    out.value.resize(w * h);
    std::vector<double> count(w * h);
    double sum = 0;
    for (const WindowPoint& p : points) {
        const auto i = size_t(std::clamp(p.x / out.cell_x, 0.0, width - 1.0)),
                   j = size_t(std::clamp(p.y * height, 0.0, height - 1.0));
        out.value[j * w + i] += p.value, ++count[j * w + i];
        sum += p.value;
    }
    const double mean = points.empty() ? 0 : sum / double(points.size());
    for (size_t i = 0; i < w; ++i) {
        double column = 0, of = 0;
        for (size_t j = 0; j < h; ++j) column += out.value[j * w + i], of += count[j * w + i];
        for (size_t j = 0; j < h; ++j) {
            double& v = out.value[j * w + i];
            const double n = count[j * w + i];
            v = n > 0 ? v / n - mean : of > 0 ? column / of - mean : 0;
        }
    }
    return out;
}

std::vector<double> amplitudes(const LightFieldWindow& window, int size, double limit_x,
                               double limit_y) {
    using Complex = std::complex<double>;
    constexpr double turn = 2 * std::numbers::pi;
    const auto n = size_t(size), w = size_t(window.width), h = size_t(window.height);
    const auto fade = [](size_t k, size_t of) {
        return 0.5 - 0.5 * std::cos(turn * (double(k) + 0.5) / double(of));
    };
    const auto frequency = [&](size_t k, double limit) {
        return n > 1 ? limit * (2 * double(k) / double(n - 1) - 1) : 0.0;
    };
    // Over x row by row, then over y.
    std::vector<Complex> rows(h * n);
    for (size_t k = 0; k < n; ++k) {
        const double f = frequency(k, limit_x) * window.cell_x;
        for (size_t i = 0; i < w; ++i) {
            const Complex wave = fade(i, w) * std::polar(1.0, -turn * f * double(i));
            for (size_t j = 0; j < h; ++j) rows[j * n + k] += wave * window.at(int(i), int(j));
        }
    }
    std::vector<double> out(n * n);
    std::vector<Complex> line(n);
    for (size_t k = 0; k < n; ++k) {
        const double f = frequency(n - 1 - k, limit_y) * window.cell_y;
        std::fill(line.begin(), line.end(), Complex{});
        for (size_t j = 0; j < h; ++j) {
            const Complex wave = fade(j, h) * std::polar(1.0, -turn * f * double(j));
            for (size_t i = 0; i < n; ++i) line[i] += wave * rows[j * n + i];
        }
        for (size_t i = 0; i < n; ++i) out[k * n + i] = std::abs(line[i]);
    }
    return out;
}

}  // namespace weft::adaptive
