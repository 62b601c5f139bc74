#include "adaptive/lens_bands.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "adaptive/slopes.h"
#include "samples/lens_shape.h"

namespace weft::adaptive {

LensBands::LensBands(int count, const Lens& lens) {
    constexpr double turn = 2 * std::numbers::pi;
    constexpr int points = 64, cells_a_cycle = 32;
    const double apart = lens_band / count;  // cycles a unit of lens
    side_ = size_t(count) * cells_a_cycle;
    scale_ = float(double(side_) * apart);
    sigma_ = float(1 / (turn * band_deviation * apart));
    table_.resize((side_ + 1) * (side_ + 1));
    // A band and the one opposite are conjugate; so are their parts of the lens's transform.
    std::vector<double> c(side_), s(side_);
    for (size_t k = 0; k < side_; ++k) {
        c[k] = std::cos(turn * double(k) / double(side_));
        s[k] = std::sin(turn * double(k) / double(side_));
    }
    const auto wrapped = [&](int k) { return size_t(k + 2 * int(side_)) % side_; };
    for (int i = -count; i <= count; ++i)
        for (int j = 0; j <= count; ++j) {
            if (i * i + j * j > count * count || (j == 0 && i < 0)) continue;
            double real = 0, imag = 0;
            for (int a = 0; a < points; ++a)
                for (int b = 0; b < points; ++b) {
                    const auto p =
                        on_lens((float(a) + 0.5f) / points, (float(b) + 0.5f) / points, lens);
                    const double angle = turn * apart * (i * double(p[0]) + j * double(p[1]));
                    real += std::cos(angle), imag -= std::sin(angle);
                }
            const double each = (i == 0 && j == 0 ? 1.0 : 2.0) / (points * points);
            real *= each, imag *= each;
            for (size_t y = 0; y <= side_; ++y)
                for (size_t x = 0; x <= side_; ++x) {
                    const size_t at = wrapped(int((int(x) * i + int(y) * j) % int(side_)));
                    table_[y * (side_ + 1) + x] += float(real * c[at] - imag * s[at]);
                }
        }
}

float LensBands::operator()(float x, float y) const {
    const auto cell = [&](float at, size_t& below) {
        const float place = at * scale_, turns = std::floor(place / float(side_)),
                    in = std::clamp(place - turns * float(side_), 0.0f, float(side_));
        below = std::min(size_t(in), side_ - 1);
        return in - float(below);
    };
    size_t i = 0, j = 0;
    const float right = cell(x, i), down = cell(y, j);
    const float* row = &table_[j * (side_ + 1) + i];
    const float above = row[0] + (row[1] - row[0]) * right;
    row += side_ + 1;
    return above + (row[0] + (row[1] - row[0]) * right - above) * down;
}

}  // namespace weft::adaptive
