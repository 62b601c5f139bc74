#include "image/display_values.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "graph/error.h"
#include "image/color_tags.h"

namespace weft {
namespace {

using Matrix = std::array<double, 9>;
using Vector = std::array<double, 3>;

Vector times(const Matrix& m, const Vector& v) {
    return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
            m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

Matrix times(const Matrix& a, const Matrix& b) {
    Matrix c = {};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                c[size_t(i * 3 + j)] += a[size_t(i * 3 + k)] * b[size_t(k * 3 + j)];
    return c;
}

Matrix inverse(const Matrix& m) {
    const Matrix cofactors = {
        m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
        m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
        m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
    const double determinant = m[0] * cofactors[0] + m[1] * cofactors[3] + m[2] * cofactors[6];
    Matrix result;
    for (size_t i = 0; i < 9; ++i) result[i] = cofactors[i] / determinant;
    return result;
}

Vector xyz(double x, double y) {
    return {x / y, 1, (1 - x - y) / y};
}

// RGB of these primaries to XYZ, white at Y = 1.
Matrix to_xyz(const Primaries& p) {
    const Vector r = xyz(p.rx, p.ry), g = xyz(p.gx, p.gy), b = xyz(p.bx, p.by);
    Matrix m = {r[0], g[0], b[0], r[1], g[1], b[1], r[2], g[2], b[2]};
    const Vector scale = times(inverse(m), xyz(p.wx, p.wy));
    for (size_t i = 0; i < 9; ++i) m[i] *= scale[i % 3];
    return m;
}

Matrix adaptation(const Vector& from, const Vector& to) {
    constexpr Matrix cone = {0.8951, 0.2664, -0.1614, -0.7502, 1.7135,
                             0.0367, 0.0389, -0.0685, 1.0296};  // Bradford
    const Vector a = times(cone, from), b = times(cone, to);
    const Matrix scale = {b[0] / a[0], 0, 0, 0, b[1] / a[1], 0, 0, 0, b[2] / a[2]};
    return times(inverse(cone), times(scale, cone));
}

Matrix to_rec709(const Primaries& p) {
    const Primaries& target = *primaries_of("lin_rec709");
    const Matrix adapt = adaptation(xyz(p.wx, p.wy), xyz(target.wx, target.wy));
    return times(inverse(to_xyz(target)), times(adapt, to_xyz(p)));
}

float within_01(float value) {
    return value > 0 ? std::min(value, 1.0f) : 0.0f;
}

}  // namespace

float srgb_from_linear(float value) {
    return value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1 / 2.4f) - 0.055f;
}

float linear_from_srgb(float value) {
    return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

RgbPixels rgb_values(const Image& image) {
    int channel[3] = {image.find("R"), image.find("G"), image.find("B")};
    if (channel[0] < 0 || channel[1] < 0 || channel[2] < 0) {
        const int grey = image.channels() == 1 ? 0 : image.find("Y");
        if (grey < 0)
            throw Error(
                fmt::format("a picture to compare needs channels R G B or Y; this one has {}",
                            fmt::join(image.names(), " ")));
        channel[0] = channel[1] = channel[2] = grey;
    }
    RgbPixels out{image.width(), image.height(), {}, 0};
    out.values.resize(size_t(image.width()) * size_t(image.height()) * 3);
    float* to = out.values.data();
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x)
            for (const int c : channel) {
                const float value = image.at(x, y)[c];
                out.not_finite += !std::isfinite(value);
                *to++ = std::isfinite(value) ? value : 0.0f;
            }
    return out;
}

RgbPixels display_values(const Image& image, Context& ctx) {
    RgbPixels out = rgb_values(image);
    const Primaries* primaries = primaries_of(image.color_space);
    const bool display = display_tag(image.color_space) || display_tag(image.display);
    if (!primaries && !display && !image.color_space.empty())
        ctx.warn(fmt::format("colour space '{}' is not known here; judged as linear Rec.709",
                             image.color_space));
    const bool rec709 = !primaries || space_of_primaries(*primaries) == "lin_rec709";
    const Matrix m = rec709 ? Matrix{1, 0, 0, 0, 1, 0, 0, 0, 1} : to_rec709(*primaries);
    ctx.parallel_rows(out.height, [&](Rows rows) {
        for (size_t i = size_t(rows.begin) * size_t(out.width);
             i < size_t(rows.end) * size_t(out.width); ++i) {
            float* rgb = out.values.data() + i * 3;
            if (display) {
                for (int c = 0; c < 3; ++c) rgb[c] = within_01(rgb[c]);
                continue;
            }
            if (!rec709) {
                const Vector v = times(m, Vector{rgb[0], rgb[1], rgb[2]});
                for (size_t c = 0; c < 3; ++c) rgb[c] = float(v[c]);
            }
            for (int c = 0; c < 3; ++c) rgb[c] = srgb_from_linear(within_01(rgb[c]));
        }
    });
    return out;
}

}  // namespace weft
