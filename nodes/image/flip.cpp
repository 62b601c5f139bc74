#include "image/flip.h"

#include <array>
#include <cmath>

#include "image/plane.h"

namespace weft {
namespace {

using Color = std::array<float, 3>;

// Linear Rec.709 to XYZ (D65), and what white gives.
constexpr float to_xyz[9] = {0.41239080f, 0.35758434f, 0.18048079f, 0.21263901f, 0.71516868f,
                             0.07219232f, 0.01933082f, 0.11919478f, 0.95053215f};
constexpr float to_rgb[9] = {3.24096994f, -1.53738318f, -0.49861076f, -0.96924364f, 1.87596750f,
                             0.04155506f, 0.05563008f,  -0.20397696f, 1.05697151f};
constexpr float white[3] = {to_xyz[0] + to_xyz[1] + to_xyz[2], to_xyz[3] + to_xyz[4] + to_xyz[5],
                            to_xyz[6] + to_xyz[7] + to_xyz[8]};

Color times(const float (&m)[9], const Color& v) {
    return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
            m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

// The opponent space of the contrast sensitivity filters, linear in XYZ: Sec. 4.1.1.
Color ycxcz_from_linear(const Color& rgb) {
    const Color xyz = times(to_xyz, rgb);
    const float x = xyz[0] / white[0], y = xyz[1] / white[1], z = xyz[2] / white[2];
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Color linear_from_ycxcz(const Color& v) {
    const float y = (v[0] + 16) / 116;
    return times(to_rgb, {(y + v[1] / 500) * white[0], y * white[1], (y - v[2] / 200) * white[2]});
}

// CIE L*a*b* with the Hunt effect: chroma counts in proportion to lightness. Sec. 4.1.2.
Color hunt_lab(const Color& rgb) {
    const auto f = [](float t) {
        constexpr float delta = 6.0f / 29;
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0f / 29;
    };
    const Color xyz = times(to_xyz, rgb);
    const float x = f(xyz[0] / white[0]), y = f(xyz[1] / white[1]), z = f(xyz[2] / white[2]);
    const float lightness = 116 * y - 16;
    return {lightness, 0.01f * lightness * 500 * (x - y), 0.01f * lightness * 200 * (y - z)};
}

float hyab(const Color& a, const Color& b) {
    return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// Exponent and the two knees that map colour distances to [0, 1].
constexpr float q_color = 0.7f, p_color = 0.4f, p_top = 0.95f, q_feature = 0.5f;

float spread(float distance, float largest) {
    const float error = std::pow(distance, q_color);
    const float knee = p_color * largest;
    return error < knee ? error * p_top / knee
                        : p_top + (error - knee) / (largest - knee) * (1 - p_top);
}

Taps gaussian(int radius, float exponent) {  // exp(-exponent x^2), x in pixels, not normalised
    Taps taps;
    for (int x = -radius; x <= radius; ++x)
        taps.push_back(std::exp(-exponent * float(x) * float(x)));
    return taps;
}

float sum(const Taps& taps) {
    double total = 0;
    for (const float tap : taps) total += tap;
    return float(total);
}

Taps scaled(Taps taps, float scale) {
    for (float& tap : taps) tap *= scale;
    return taps;
}

// Contrast sensitivity: a sum of Gaussians a sqrt(pi / b) exp(-pi^2 d^2 / b) over degrees d;
// Table 1.
struct Sensitivity {
    float a1, b1, a2, b2;
};
constexpr Sensitivity sensitivities[3] = {
    {1.0f, 0.0047f, 0.0f, 1e-5f}, {1.0f, 0.0053f, 0.0f, 1e-5f}, {34.1f, 0.04f, 13.5f, 0.025f}};
constexpr float widest = 0.04f;

struct Opponent {
    Plane planes[3];  // achromatic, red-green, blue-yellow
};

Opponent opponent(const RgbPixels& picture, Context& ctx) {
    Opponent out;
    for (Plane& plane : out.planes) plane = Plane(picture.width, picture.height);
    ctx.parallel_rows(picture.height, [&](Rows rows) {
        for (int y = rows.begin; y < rows.end; ++y)
            for (int x = 0; x < picture.width; ++x) {
                const float* rgb = picture.at(x, y);
                const Color v = ycxcz_from_linear(
                    {linear_from_srgb(rgb[0]), linear_from_srgb(rgb[1]), linear_from_srgb(rgb[2])});
                for (size_t c = 0; c < 3; ++c) out.planes[c].row(y)[x] = v[c];
            }
    });
    return out;
}

Opponent seen(const Opponent& in, float ppd, Context& ctx) {
    const float pi = 3.14159265358979f;
    const int radius = int(std::ceil(3 * std::sqrt(widest / (2 * pi * pi)) * ppd));
    Opponent out;
    for (size_t c = 0; c < 3; ++c) {
        const Sensitivity& s = sensitivities[c];
        const Taps g1 = gaussian(radius, pi * pi / (s.b1 * ppd * ppd));
        const float w1 = s.a1 * std::sqrt(pi / s.b1), sum1 = sum(g1);
        if (s.a2 == 0) {
            const Taps unit = scaled(g1, 1 / sum1);
            out.planes[c] = filtered(in.planes[c], unit, unit, ctx);
            continue;
        }
        const Taps g2 = gaussian(radius, pi * pi / (s.b2 * ppd * ppd));
        const float w2 = s.a2 * std::sqrt(pi / s.b2), sum2 = sum(g2);
        const float total = w1 * sum1 * sum1 + w2 * sum2 * sum2;
        out.planes[c] = filtered(in.planes[c], scaled(g1, w1 / total), g1, ctx);
        const Plane second = filtered(in.planes[c], scaled(g2, w2 / total), g2, ctx);
        for (size_t i = 0; i < second.values.size(); ++i)
            out.planes[c].values[i] += second.values[i];
    }
    return out;
}

// Positive weights sum to one, negative ones to minus one.
Taps balanced(Taps taps) {
    float positive = 0, negative = 0;
    for (const float tap : taps) (tap > 0 ? positive : negative) += tap;
    for (float& tap : taps) tap /= tap > 0 ? positive : -negative;
    return taps;
}

struct Features {
    Plane edges, points;  // magnitudes
};

// Edges and points of the achromatic channel: first and second derivatives of a Gaussian as wide as
// the smallest feature seen as one, 0.082 degrees. Sec. 4.2.
Features features(const Plane& achromatic, float ppd, Context& ctx) {
    const float deviation = 0.5f * 0.082f * ppd;
    const int radius = int(std::ceil(3 * deviation));
    const Taps g = gaussian(radius, 1 / (2 * deviation * deviation));
    Taps first, second;
    for (int x = -radius; x <= radius; ++x) {
        const float weight = g[size_t(x + radius)];
        first.push_back(-float(x) * weight);
        second.push_back((float(x) * float(x) / (deviation * deviation) - 1) * weight);
    }
    const Taps smooth = scaled(g, 1 / sum(g)), edge = balanced(first), point = balanced(second);
    Plane normal = achromatic;
    for (float& value : normal.values) value = (value + 16) / 116;
    const auto magnitude = [&](const Taps& along) {
        Plane out = filtered(normal, along, smooth, ctx);
        const Plane other = filtered(normal, smooth, along, ctx);
        for (size_t i = 0; i < out.values.size(); ++i)
            out.values[i] = std::hypot(out.values[i], other.values[i]);
        return out;
    };
    return {magnitude(edge), magnitude(point)};
}

}  // namespace

std::vector<float> flip_map(const RgbPixels& reference, const RgbPixels& test, float ppd,
                            Context& ctx) {
    const Opponent reference_colors = opponent(reference, ctx), test_colors = opponent(test, ctx);
    const Opponent reference_seen = seen(reference_colors, ppd, ctx),
                   test_seen = seen(test_colors, ppd, ctx);
    const Features reference_features = features(reference_colors.planes[0], ppd, ctx);
    const Features test_features = features(test_colors.planes[0], ppd, ctx);

    // The largest distance there is, between green and blue.
    const float largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), q_color);
    std::vector<float> map(reference_seen.planes[0].values.size());
    const auto lab_at = [](const Opponent& o, size_t i) {
        Color rgb = linear_from_ycxcz(
            {o.planes[0].values[i], o.planes[1].values[i], o.planes[2].values[i]});
        for (float& value : rgb) value = std::min(std::max(value, 0.0f), 1.0f);
        return hunt_lab(rgb);
    };
    ctx.parallel_rows(reference.height, [&](Rows rows) {
        const size_t width = size_t(reference.width);
        for (size_t i = size_t(rows.begin) * width; i < size_t(rows.end) * width; ++i) {
            const float color =
                spread(hyab(lab_at(reference_seen, i), lab_at(test_seen, i)), largest);
            const float edges =
                std::abs(reference_features.edges.values[i] - test_features.edges.values[i]);
            const float points =
                std::abs(reference_features.points.values[i] - test_features.points.values[i]);
            const float feature = std::pow(std::max(edges, points) / std::sqrt(2.0f), q_feature);
            map[i] = std::pow(color, 1 - std::min(feature, 1.0f));
        }
    });
    return map;
}

}  // namespace weft
