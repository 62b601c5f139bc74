#include "shadows/light_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/error.h"

namespace weft::shadows {
namespace {

using Corners = WorldMesh::Corners;

Point3 unit(Point3 a) {
    return a * (1 / std::sqrt(dot(a, a)));
}
// As long as twice the area.
Point3 normal_of(const Corners& t) {
    return cross(t[1] - t[0], t[2] - t[0]);
}
double area_of(const Corners& t) {
    const Point3 n = normal_of(t);
    return 0.5 * std::sqrt(dot(n, n));
}

// Axes that go with a triangle.
Map3 axes_of(const Corners& t) {
    const Point3 x = unit(t[1] - t[0]), z = unit(normal_of(t));
    return {x, cross(z, x), z, {}};
}

// The sides of a rectangle on a plane, and its middle.
struct Rectangle {
    Point3 x, y;
    double left = 1e300, right = -1e300, top = 1e300, bottom = -1e300;
    double area() const { return (right - left) * (bottom - top); }
};
Rectangle around(const std::vector<Corners>& triangles, Point3 x, Point3 z) {
    Rectangle r{x, cross(z, x)};
    for (const Corners& t : triangles)
        for (const Point3 p : t) {
            r.left = std::min(r.left, dot(p, r.x)), r.right = std::max(r.right, dot(p, r.x));
            r.top = std::min(r.top, dot(p, r.y)), r.bottom = std::max(r.bottom, dot(p, r.y));
        }
    return r;
}
Rectangle smallest(const std::vector<Corners>& triangles, Point3 z) {
    constexpr size_t most_edges = 192;
    Rectangle best;
    bool any = false;
    const size_t step = triangles.size() * 3 / most_edges + 1;
    for (size_t e = 0; e < triangles.size() * 3; e += step) {
        const Corners& t = triangles[e / 3];
        const Point3 edge = t[(e + 1) % 3] - t[e % 3], along = edge - z * dot(edge, z);
        if (!(dot(along, along) > 1e-12 * dot(edge, edge)) || !(dot(edge, edge) > 0)) continue;
        const Rectangle r = around(triangles, unit(along), z);
        if (!any || r.area() < best.area()) best = r;
        any = true;
    }
    return best;
}

}  // namespace

void place_mesh(const WorldMesh& mesh, Point3 towards, const std::string& what, LightView& view) {
    const size_t n = mesh.open.size();
    double area = 0, sum = 0;
    Point3 normal, middle;
    size_t largest = 0;
    const auto chance = [&](size_t i) {
        return mesh.chances.empty() ? area_of(mesh.open[i]) : mesh.chances[i];
    };
    for (size_t i = 0; i < n; ++i) {
        const Corners& t = mesh.open[i];
        const double own = area_of(t);
        area += own, sum += chance(i);
        if (own > area_of(mesh.open[largest])) largest = i;
        normal = normal + normal_of(t) * 0.5;
        middle = middle + (t[0] + t[1] + t[2]) * (chance(i) / 3);
    }
    if (!(area > 0) || !(sum > 0) || !std::isfinite(area) || !std::isfinite(sum))
        throw Error(fmt::format("none of the {} triangles of {} shines and has an area", n, what));
    middle = middle * (1 / sum);
    // A half-ball's mean normal is half as long as its area is large.
    const bool ahead = std::sqrt(dot(normal, normal)) > 0.49 * area;
    Point3 z = towards - middle;
    const bool aside = !(dot(z, z) > 0);
    if (ahead && (aside || !mesh.two_sided || dot(normal, z) > 0))
        z = normal;
    else if (ahead)
        z = normal * -1.0;
    else if (aside)
        z = {0, 0, 1};
    z = unit(z);

    const Rectangle r = smallest(mesh.open, z);
    const double half_x = 0.5 * (r.right - r.left), half_y = 0.5 * (r.bottom - r.top);
    const Point3 origin = r.x * (0.5 * (r.left + r.right)) + r.y * (0.5 * (r.top + r.bottom)) +
                          z * dot(middle, z);
    view.light_to_world[0] = {r.x, r.y, z, origin};
    view.light_to_world[1] = view.light_to_world[0];
    if (!mesh.close.empty()) {
        if (!(area_of(mesh.close[largest]) > 0))
            throw Error(fmt::format("{} changes shape: it loses its area", what));
        // Its largest triangle takes the frame along.
        const Map3 from = axes_of(mesh.open[largest]), to = axes_of(mesh.close[largest]);
        const auto turned = [&](Point3 v) {
            return to.x * dot(v, from.x) + to.y * dot(v, from.y) + to.z * dot(v, from.z);
        };
        view.light_to_world[1] = {
            turned(r.x), turned(r.y), turned(z),
            mesh.close[largest][0] + turned(origin - mesh.open[largest][0])};
    }
    for (const size_t end : {0, 1}) view.world_to_light[end] = inverse(view.light_to_world[end]);

    view.ax = half_x, view.ay = half_y;
    view.radius = std::sqrt(half_x * half_y);
    view.two_sided = mesh.two_sided;
    const double size = std::hypot(half_x, half_y);
    double before = 0, thick = 0;
    view.triangles.reserve(n);
    for (size_t i = 0; i < n; ++i) {
        Corners t = mesh.open[i];
        for (size_t c = 0; c < 3; ++c) {
            t[c] = view.world_to_light[0].point(t[c]);
            thick = std::max(thick, std::abs(t[c].z));
            if (mesh.close.empty()) continue;
            const Point3 moved = view.world_to_light[1].point(mesh.close[i][c]) - t[c];
            if (!(dot(moved, moved) < 1e-6 * size * size))
                throw Error(
                    fmt::format("{} changes shape while the shutter is open; expected a mesh that "
                                "moves as a whole",
                                what));
        }
        before += chance(i) / sum;
        view.triangles.push_back({t[0], t[1], t[2], before});
    }
    view.flat = thick < 1e-5 * size;
}

}  // namespace weft::shadows
