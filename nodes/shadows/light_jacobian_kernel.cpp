#include "shadows/light_jacobian_kernel.h"

#include <algorithm>
#include <cmath>

namespace weft::shadows {
namespace {

// J with its singular values clamped: J J^T = U diag(s^2) U^T, so U diag(s' / s) U^T J.
Jacobian clamped(const Jacobian& j, double low, double high) {
    const auto m = metric_of(j);
    const double mean = 0.5 * (m[0] + m[2]), spread = std::hypot(0.5 * (m[0] - m[2]), m[1]);
    const double s1 = std::sqrt(std::max(mean + spread, 0.0)),
                 s2 = std::sqrt(std::max(mean - spread, 0.0));
    if (s2 >= low && s1 <= high) return j;
    const double angle = 0.5 * std::atan2(2 * m[1], m[0] - m[2]), c = std::cos(angle),
                 s = std::sin(angle);
    const double f1 = s1 > 0 ? std::clamp(s1, low, high) / s1 : 0;
    // The lesser one may be lost altogether: then its direction is all that is known.
    const double to = std::clamp(s2, low, high);
    Jacobian out;
    const bool flat = !(s2 > 1e-9 * s1) || s1 == 0;
    const double f2 = flat ? 0 : to / s2;
    for (size_t k = 0; k < 2; ++k) {
        const double along = (c * j[0][k] + s * j[1][k]) * f1,
                     across = (-s * j[0][k] + c * j[1][k]) * f2;
        out[0][k] = c * along - s * across;
        out[1][k] = s * along + c * across;
    }
    if (!flat) return out;
    if (s1 == 0) return {{{low, 0}, {0, low}}};
    // In the pixel's direction that J takes to nothing: the one across its row along U's first
    // column.
    const double bx = (c * j[0][0] + s * j[1][0]) / s1, by = (c * j[0][1] + s * j[1][1]) / s1;
    out[0][0] += -s * to * -by, out[0][1] += -s * to * bx;
    out[1][0] += c * to * -by, out[1][1] += c * to * bx;
    return out;
}

}  // namespace

Jacobian light_jacobian(const LightView& view, const Map3& m, Point3 pixel, Point3 normal,
                        double most) {
    const Point3 p = m.point(pixel);
    // Along the pixel's ray a point is at origin + d z with d = M (x, y, 1); on the plane z = n.(p
    // - origin) / n.d, and a pixel moves d by M's first or second column.
    const double z = pixel.z;
    const Point3 d = m.vector(pixel * (1 / z));
    const double facing = dot(normal, d);
    const bool edge_on = !(std::abs(facing) > 1e-6 * std::sqrt(dot(d, d) * dot(normal, normal)));
    Jacobian j;
    const std::array<Point3, 2> columns{m.x, m.y};
    const double per_w = view.k / p.z;
    for (size_t c = 0; c < 2; ++c) {
        const Point3 e = columns[c];
        const Point3 step = edge_on ? e * z : (e - d * (dot(normal, e) / facing)) * z;
        j[0][c] = per_w * (step.x - p.x / p.z * step.z);
        j[1][c] = per_w * (step.y - p.y / p.z * step.z);
    }
    // A surface that faces the camera and the light.
    const double scale = per_w * z * std::sqrt(0.5 * (dot(m.x, m.x) + dot(m.y, m.y)));
    return clamped(j, scale / most, scale * most);
}

double area_of(const Jacobian& j) {
    return std::abs(j[0][0] * j[1][1] - j[0][1] * j[1][0]);
}

std::array<double, 3> metric_of(const Jacobian& j) {
    return {j[0][0] * j[0][0] + j[0][1] * j[0][1], j[0][0] * j[1][0] + j[0][1] * j[1][1],
            j[1][0] * j[1][0] + j[1][1] * j[1][1]};
}

}  // namespace weft::shadows
