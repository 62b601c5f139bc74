#include "render/shapes.h"

#include <algorithm>
#include <cmath>

#include "render/affine.h"

namespace weft {
namespace {

// A sheet of (columns + 1) x (rows + 1) points, u to the right and v down, facing the viewer.
template <class Point>
Mesh sheet(int columns, int rows, Point&& point) {
    Mesh mesh;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const Vec2 uv{float(i) / float(columns), float(j) / float(rows)};
            const auto [p, n] = point(uv);
            mesh.positions.push_back(p), mesh.normals.push_back(n), mesh.uv.push_back(uv);
        }
    const auto at = [&](int i, int j) { return std::uint32_t(j * (columns + 1) + i); };
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
        }
    return mesh;
}

// Triangles without area come from points on the axis.
void drop_slivers(Mesh& mesh) {
    std::erase_if(mesh.triangles, [&](const auto& t) {
        const Vec3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
        const Vec3 n = cross(b - a, c - a);
        return !(dot(n, n) > 0);
    });
}

}  // namespace

Mesh plane_mesh(int cells) {
    return sheet(cells, cells, [](Vec2 uv) {
        return std::pair{Vec3{2 * uv.x - 1, 0, 2 * uv.y - 1}, Vec3{0, 1, 0}};
    });
}

Mesh wall_mesh(int cells) {
    return sheet(cells, cells, [](Vec2 uv) {
        return std::pair{Vec3{2 * uv.x - 1, 1 - 2 * uv.y, 0}, Vec3{0, 0, 1}};
    });
}

Mesh disc_mesh(int segments) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}}, mesh.normals = {{0, 1, 0}}, mesh.uv = {{0.5f, 0.5f}};
    for (int i = 0; i < segments; ++i) {
        const float a = 2 * pi * float(i) / float(segments), x = std::cos(a), z = -std::sin(a);
        mesh.positions.push_back({x, 0, z});
        mesh.normals.push_back({0, 1, 0});
        mesh.uv.push_back({0.5f + 0.5f * x, 0.5f + 0.5f * z});
        mesh.triangles.push_back({0, std::uint32_t(i + 1), std::uint32_t((i + 1) % segments + 1)});
    }
    return mesh;
}

Mesh cube_mesh() {
    Mesh mesh;
    const Mesh wall = wall_mesh();
    const Affine out = translate({0, 0, 1});
    for (int i = 0; i < 4; ++i) append(mesh, wall, rotate({0, 1, 0}, float(i) * pi / 2) * out);
    append(mesh, wall, rotate({1, 0, 0}, -pi / 2) * out);
    append(mesh, wall, rotate({1, 0, 0}, pi / 2) * out);
    return mesh;
}

Mesh sphere_mesh(int segments) {
    Mesh mesh = sheet(segments, std::max(segments / 2, 2), [](Vec2 uv) {
        const float a = 2 * pi * uv.x, b = pi * uv.y, r = std::sin(b);
        const Vec3 p{r * std::sin(a), std::cos(b), r * std::cos(a)};
        return std::pair{p, p};
    });
    // The poles, exactly: r is not quite 0 there.
    for (int i = 0; i <= segments; ++i) {
        mesh.positions[size_t(i)] = mesh.normals[size_t(i)] = {0, 1, 0};
        const size_t last = mesh.positions.size() - 1 - size_t(i);
        mesh.positions[last] = mesh.normals[last] = {0, -1, 0};
    }
    drop_slivers(mesh);
    return mesh;
}

Mesh lathe_mesh(std::span<const Vec2> profile, int segments, float crease) {
    Mesh mesh;
    if (profile.size() < 2) return mesh;
    std::vector<Vec2> side(profile.size() - 1);  // each piece's outward normal (radial, height)
    std::vector<float> along(profile.size(), 0);
    for (size_t i = 0; i + 1 < profile.size(); ++i) {
        const float dr = profile[i + 1].x - profile[i].x, dh = profile[i + 1].y - profile[i].y;
        const float size = std::hypot(dr, dh);
        side[i] = size > 0 ? Vec2{dh / size, -dr / size} : Vec2{1, 0};
        along[i + 1] = along[i] + size;
    }
    const auto meet = [&](size_t piece, size_t other) {
        const Vec2 a = side[piece], b = side[other];
        if (a.x * b.x + a.y * b.y < std::cos(crease)) return a;
        const float size = std::hypot(a.x + b.x, a.y + b.y);
        return Vec2{(a.x + b.x) / size, (a.y + b.y) / size};
    };
    const bool closed = profile.front() == profile.back();
    for (size_t i = 0; i < side.size(); ++i) {
        const size_t before = i > 0 ? i - 1 : closed ? side.size() - 1 : i;
        const size_t after = i + 1 < side.size() ? i + 1 : closed ? 0 : i;
        const Vec2 low = meet(i, before), high = meet(i, after);
        append(mesh, sheet(segments, 1, [&](Vec2 uv) {
                   const size_t k = uv.y > 0.5f ? i : i + 1;  // v runs down
                   const Vec2 n = k == i ? low : high;
                   const float a = uv.x < 1 ? 2 * pi * uv.x : 0, c = std::cos(a), s = std::sin(a);
                   return std::pair{Vec3{profile[k].x * s, profile[k].y, profile[k].x * c},
                                    Vec3{n.x * s, n.y, n.x * c}};
               }));
        const size_t begin = mesh.uv.size() - 2 * size_t(segments + 1);
        const float total = along.back() > 0 ? along.back() : 1;
        for (size_t v = begin; v < mesh.uv.size(); ++v)
            mesh.uv[v].y = 1 - along[mesh.uv[v].y > 0.5f ? i : i + 1] / total;
    }
    drop_slivers(mesh);
    return mesh;
}

Mesh torus_mesh(float tube, int segments) {
    std::vector<Vec2> circle;
    const int around = std::max(segments / 3, 6);
    for (int i = 0; i < around; ++i) {
        const float a = 2 * pi * float(i) / float(around) - pi;
        circle.push_back({1 + tube * std::cos(a), tube * std::sin(a)});
    }
    circle.push_back(circle.front());
    return lathe_mesh(circle, segments, 2);
}

Mesh tube_mesh(std::span<const Vec3> points, std::span<const float> radii, int segments) {
    if (points.size() < 2) return {};
    // A frame carried along the curve without twist: each turns the last into the new direction.
    Vec3 right{};
    std::vector<Affine> frames;
    for (size_t i = 0; i < points.size(); ++i) {
        const Vec3 ahead = points[std::min(i + 1, points.size() - 1)] - points[i > 0 ? i - 1 : 0];
        const Vec3 y = dot(ahead, ahead) > 0 ? unit(ahead) : Vec3{0, 1, 0};
        right = right - y * dot(right, y);
        if (dot(right, right) < 1e-8f)
            right = cross(y, std::fabs(y.x) < 0.8f ? Vec3{1, 0, 0} : Vec3{0, 0, 1});
        right = unit(right);
        frames.push_back({right, y, cross(right, y), points[i]});
    }
    const int rows = int(points.size()) - 1;
    return sheet(segments, rows, [&](Vec2 uv) {
        const size_t i = size_t(std::lround((1 - uv.y) * float(rows)));
        const float a = uv.x < 1 ? 2 * pi * uv.x : 0;
        const Vec3 n = frames[i].vector({std::sin(a), 0, std::cos(a)});
        return std::pair{points[i] + n * radii[i], n};
    });
}

std::vector<Vec2> smooth_profile(std::span<const Vec2> points, int steps) {
    std::vector<Vec2> curve;
    const auto at = [&](size_t i, int d) {
        const auto k =
            std::clamp<std::ptrdiff_t>(std::ptrdiff_t(i) + d, 0, std::ptrdiff_t(points.size()) - 1);
        return points[size_t(k)];
    };
    for (size_t i = 0; i + 1 < points.size(); ++i)
        for (int k = 0; k < steps; ++k) {
            const float t = float(k) / float(steps), t2 = t * t, t3 = t2 * t;
            const float w[] = {-t3 + 2 * t2 - t, 3 * t3 - 5 * t2 + 2, -3 * t3 + 4 * t2 + t,
                               t3 - t2};
            Vec2 p;
            for (int d = 0; d < 4; ++d)
                p.x += 0.5f * w[d] * at(i, d - 1).x, p.y += 0.5f * w[d] * at(i, d - 1).y;
            curve.push_back({std::max(p.x, 0.0f), p.y});
        }
    if (!points.empty()) curve.push_back(points.back());
    return curve;
}

void append(Mesh& mesh, const Mesh& part, const Affine& at) {
    const auto first = std::uint32_t(mesh.positions.size());
    const bool uv = (first == 0 || !mesh.uv.empty()) && !part.uv.empty();
    const bool normals = (first == 0 || !mesh.normals.empty()) && !part.normals.empty();
    if (!uv) mesh.uv.clear();
    if (!normals) mesh.normals.clear();
    const Affine n{cross(at.y, at.z), cross(at.z, at.x), cross(at.x, at.y), {}};  // cofactors
    const bool mirrored = determinant(at) < 0;
    for (size_t i = 0; i < part.positions.size(); ++i) {
        mesh.positions.push_back(at.point(part.positions[i]));
        if (uv) mesh.uv.push_back(part.uv[i]);
        if (normals) {
            const Vec3 turned = n.vector(part.normals[i]) * (mirrored ? -1.0f : 1.0f);
            mesh.normals.push_back(dot(turned, turned) > 0 ? unit(turned) : part.normals[i]);
        }
    }
    for (auto t : part.triangles) {
        if (mirrored) std::swap(t[1], t[2]);
        mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
}

void make_normals(Mesh& mesh) {
    mesh.normals.assign(mesh.positions.size(), Vec3{});
    const size_t count = mesh.vertices();
    for (size_t first = 0; first < mesh.positions.size(); first += count) {
        for (const auto& t : mesh.triangles) {
            const Vec3 a = mesh.positions[first + t[0]], b = mesh.positions[first + t[1]];
            const Vec3 n = cross(b - a, mesh.positions[first + t[2]] - a);  // twice the area
            for (const std::uint32_t v : t) mesh.normals[first + v] += n;
        }
        for (size_t v = first; v < first + count; ++v) {
            const float size = length(mesh.normals[v]);
            mesh.normals[v] = size > 0 ? mesh.normals[v] * (1 / size) : Vec3{0, 1, 0};
        }
    }
}

}  // namespace weft
