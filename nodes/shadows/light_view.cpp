#include "shadows/light_view.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "samples/random.h"

namespace weft {
namespace {

// The unit square to the unit disc, areas kept (Shirley and Chiu 1997).
std::array<double, 2> concentric(double a, double b) {
    const double x = 2 * a - 1, y = 2 * b - 1;
    if (x == 0 && y == 0) return {0, 0};
    constexpr double quarter = std::numbers::pi / 4;
    const bool wide = std::abs(x) > std::abs(y);
    const double r = wide ? x : y, angle = wide ? quarter * y / x : 2 * quarter - quarter * x / y;
    return {r * std::cos(angle), r * std::sin(angle)};
}

}  // namespace

Map3 inverse(const Map3& m) {
    const Point3 yz = cross(m.y, m.z), zx = cross(m.z, m.x), xy = cross(m.x, m.y);
    const double scale = 1 / dot(m.x, yz);
    Map3 out{Point3{yz.x, zx.x, xy.x} * scale,
             Point3{yz.y, zx.y, xy.y} * scale,
             Point3{yz.z, zx.z, xy.z} * scale,
             {}};
    out.origin = out.vector(m.origin) * -1.0;
    return out;
}

Lens LightView::lens() const {
    Lens out;
    out.c0 = float(c0y());
    out.c1 = float(c1y());
    out.aspect = ay > 0 ? float(ax / ay) : 1.0f;
    return out;
}

Point3 LightView::to_world(Point3 p, double t) const {
    const Map3 &a = world_to_light[0], &b = world_to_light[1];
    if (t <= 0) return light_to_world[0].point(p);
    const auto between = [&](Point3 open, Point3 close) { return open + (close - open) * t; };
    return inverse({between(a.x, b.x), between(a.y, b.y), between(a.z, b.z),
                    between(a.origin, b.origin)})
        .point(p);
}

std::array<double, 2> LightView::inverse_depth_gradient(Point3 p, Point3 n) const {
    // 1/w = n.dir / n.p with dir = (X/w, Y/w, 1), and a px moves dir by 1/k.
    const double plane = dot(n, p), facing = plane / p.z;
    if (!(std::abs(facing) >= 1e-3 * std::sqrt(dot(n, n)))) return {0, 0};
    return {n.x / (k * plane), n.y / (k * plane)};
}

LightPoint LightView::draw(double a, double b, Point3 p) const {
    switch (shape) {
        case Shape::quad:
            return {2 * a - 1, 2 * b - 1};
        case Shape::disc: {
            const auto at = concentric(a, b);
            return {at[0], at[1]};
        }
        case Shape::point:
            return {};
        case Shape::mesh:
            return on_mesh(a, b, p);
        case Shape::sphere:
            break;
    }
    return on_ball(a, b, p);
}

// Even over the cone that holds the ball, as Lights::sample draws it (Pharr et al., Physically
// Based Rendering, Sec. 6.2); then on to the plane through the centre.
LightPoint LightView::on_ball(double a, double b, Point3 p) const {
    const double distance2 = dot(p, p), sine2 = std::min(radius * radius / distance2, 0.999);
    const double cosine = 1 - a * (1 - std::sqrt(1 - sine2)),
                 sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const double angle = 2 * std::numbers::pi * b;
    const Point3 axis = p * (-1 / std::sqrt(distance2));
    const Point3 aside = std::abs(axis.x) < 0.7 ? Point3{1, 0, 0} : Point3{0, 1, 0};
    Point3 right = cross(aside, axis);
    right = right * (1 / std::sqrt(dot(right, right)));
    const Point3 up = cross(axis, right);
    const Point3 d =
        axis * cosine + right * (sine * std::cos(angle)) + up * (sine * std::sin(angle));
    LightPoint out = seen_through(p + d, p);
    out.depth = 0;  // rays start within the ball, which stops none
    return out;
}

// A triangle by its part of the light and an even point of it, as Lights::sample draws them. Of a
// mesh that is not flat, points that face the receiver, as often as they look large from there.
LightPoint LightView::on_mesh(double a, double b, Point3 p) const {
    constexpr int most_tries = 16;
    const auto key = [](double x) { return mix(std::bit_cast<std::uint64_t>(x)); };
    std::uint64_t bits = mix(key(a) ^ std::rotl(key(b), 1));
    Point3 at;
    for (int i = 0; i < most_tries; ++i) {
        const auto found = std::upper_bound(
            triangles.begin(), triangles.end(), a,
            [](double number, const LightTriangle& t) { return number < t.end; });
        const size_t t = std::min(size_t(found - triangles.begin()), triangles.size() - 1);
        const LightTriangle& one = triangles[t];
        const double begin = t > 0 ? triangles[t - 1].end : 0, part = one.end - begin;
        const double root = std::sqrt(part > 0 ? std::clamp((a - begin) / part, 0.0, 1.0) : 0.5);
        at = one.a + (one.b - one.a) * (1 - root) + (one.c - one.a) * (b * root);
        if (flat) return {at.x / ax, at.y / ay};
        const Point3 normal = cross(one.b - one.a, one.c - one.a), way = p - at;
        double cosine = dot(normal, way) / std::sqrt(dot(normal, normal) * dot(way, way));
        if (two_sided) cosine = std::abs(cosine);
        const auto next = [&] { return double(unit_float(bits = mix(bits))); };
        if (next() < cosine) break;
        a = next(), b = next();
    }
    return seen_through(at, p);
}

// Where the ray from a point of the light to a receiver crosses the plane. A receiver that sees the
// plane edge-on would look past the film's reach.
LightPoint LightView::seen_through(Point3 at, Point3 p) const {
    if (shape == Shape::point || !(at.z < p.z)) return {};
    const Point3 on_plane = p + (at - p) * (p.z / (p.z - at.z));
    return {std::clamp(on_plane.x / ax, -1.0, 1.0), std::clamp(on_plane.y / ay, -1.0, 1.0), at.z};
}

}  // namespace weft
