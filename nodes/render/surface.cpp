#include "render/surface.h"

#include <algorithm>

namespace weft::render {
namespace {

float widest(Vec3 v) {
    return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

// Of motion keys at equal steps: the one before `time`, and how far it is to the next.
struct Step {
    size_t index;
    float part;
};
Step step_of(int steps, float time) {
    if (steps == 1) return {0, 0};
    const float place = time * float(steps - 1);
    const size_t i = std::min(size_t(std::max(place, 0.0f)), size_t(steps - 2));
    return {i, place - float(i)};
}

struct Corners {
    Vec3 a, b, c;
    Vec3 at(float u, float v) const { return a * (1 - u - v) + b * u + c * v; }
};
Corners corners_of(const Mesh& mesh, const std::vector<Vec3>& values, std::uint32_t primitive,
                   float time) {
    const Step step = step_of(mesh.steps, time);
    const size_t vertices = mesh.vertices();
    const auto& triangle = mesh.triangles[primitive];
    const Vec3* now = values.data() + step.index * vertices;
    if (step.part == 0) return {now[triangle[0]], now[triangle[1]], now[triangle[2]]};
    const Vec3* next = now + vertices;
    const auto mixed = [&](std::uint32_t i) { return lerp(now[i], next[i], step.part); };
    return {mixed(triangle[0]), mixed(triangle[1]), mixed(triangle[2])};
}

UvFrame uv_frame(const std::vector<Vec2>& uv, const std::array<std::uint32_t, 3>& triangle, float u,
                 float v, const Corners& p, const Affine& to_world) {
    UvFrame out;
    if (uv.empty()) return out;
    const Vec2 a = uv[triangle[0]], b = uv[triangle[1]], c = uv[triangle[2]];
    const float w = 1 - u - v;
    out.uv = {a.x * w + b.x * u + c.x * v, a.y * w + b.y * u + c.y * v};
    const Vec2 e{b.x - a.x, b.y - a.y}, f{c.x - a.x, c.y - a.y};
    const float area = e.x * f.y - e.y * f.x;
    if (area != 0) {
        const Vec3 ab = p.b - p.a, ac = p.c - p.a;
        out.along_u = to_world.vector((ab * f.y - ac * e.y) * (1 / area));
        out.along_v = to_world.vector((ac * e.x - ab * f.x) * (1 / area));
    }
    return out;
}

Vec3 light_point(const Object& object, std::uint32_t primitive, float u, float v) {
    if (object.kind != Object::Kind::sphere) return {2 * u - 1, 2 * v - 1, 0};
    const float z = std::sqrt(std::max(0.0f, 1 - u * u - v * v));
    return {u, v, primitive ? -z : z};
}

// Rounding of ray and triangle (robust intersection) and of ours: about 16 half units in the last
// place of the largest coordinate on the way.
constexpr float rounding = 1e-6f;

}  // namespace

Vec3 position_at(const Object& object, std::uint32_t primitive, float u, float v, float time) {
    const Affine to_world = object.placement.at(time);
    if (!object.mesh) return to_world.point(light_point(object, primitive, u, v));
    return to_world.point(
        corners_of(*object.mesh, object.mesh->positions, primitive, time).at(u, v));
}

SurfacePoint surface_at(const Object& object, std::uint32_t primitive, float u, float v,
                        float time) {
    const Affine to_world = object.placement.at(time);
    SurfacePoint out;
    if (!object.mesh) {
        const Vec3 local = light_point(object, primitive, u, v);
        const bool sphere = object.kind == Object::Kind::sphere;
        out.position = to_world.point(local);
        out.geometric = unit(transformed_normal(to_world, sphere ? local : Vec3{0, 0, -1}));
        out.shading = out.geometric;
        out.texture.uv = {u, v};
        out.error = rounding * (widest(out.position) + widest(to_world.x));
        return out;
    }
    const Mesh& mesh = *object.mesh;
    const Corners p = corners_of(mesh, mesh.positions, primitive, time);
    const Vec3 ab = p.b - p.a, ac = p.c - p.a;
    const Vec3 local = p.at(u, v);
    out.position = to_world.point(local);
    Vec3 n = transformed_normal(to_world, cross(ab, ac));
    const float size = length(n);
    out.geometric = size > 0 ? n * (1 / size) : Vec3{0, 0, 1};
    out.shading = out.geometric;
    if (!mesh.normals.empty()) {
        n = transformed_normal(to_world, corners_of(mesh, mesh.normals, primitive, time).at(u, v));
        const float l = length(n);
        if (l > 0) out.shading = n * (1 / l);
    }
    const float reach = widest(local) + std::max(widest(ab), widest(ac));
    const float scale = std::max({widest(to_world.x), widest(to_world.y), widest(to_world.z)});
    out.error = rounding * (widest(out.position) + scale * reach + widest(to_world.origin));
    out.texture = uv_frame(mesh.uv, mesh.triangles[primitive], u, v, p, to_world);
    return out;
}

UvFrame uv_frame_at(const Object& object, std::uint32_t primitive, float u, float v, float time,
                    int set) {
    if (!object.mesh) return {{u, v}, {}, {}};
    const Mesh& mesh = *object.mesh;
    return uv_frame(mesh.uv_set(set), mesh.triangles[primitive], u, v,
                    corners_of(mesh, mesh.positions, primitive, time), object.placement.at(time));
}

}  // namespace weft::render
