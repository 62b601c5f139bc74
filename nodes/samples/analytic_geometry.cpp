#include "samples/analytic_geometry.h"

#include <algorithm>
#include <numeric>

namespace weft::analytic {
namespace {

constexpr float near_depth = 0.05f;
constexpr float infinity = std::numeric_limits<float>::infinity();

// Pixels that a primitive can be seen in from anywhere on the lens at any time of the shutter, and
// the smallest depth it takes.
struct Bounds {
    float x0 = infinity, y0 = infinity, x1 = -infinity, y1 = -infinity, nearest = infinity;

    void add(const Camera& camera, Vec3 p) {
        nearest = std::min(nearest, p.z);
        if (p.z < near_depth) {  // behind the lens: anywhere
            x0 = y0 = -infinity;
            x1 = y1 = infinity;
            return;
        }
        const Lens lens = camera.lens();
        const float x = camera.center_x + camera.scale * p.x / p.z;
        const float y = camera.center_y + camera.scale * p.y / p.z;
        const float blur = std::fabs(lens.c0 / p.z + lens.c1) + 0.01f;
        x0 = std::min(x0, x - blur), x1 = std::max(x1, x + blur);
        y0 = std::min(y0, y - blur), y1 = std::max(y1, y + blur);
    }
};

// For every lens position a straight path is seen straight, and a convex thing within the hull of
// its corners: so corners at both ends of the shutter bound all of it.
Bounds bounds_of(const Primitive& p, const Camera& camera) {
    Bounds bounds;
    constexpr float k = 0.41421357f;  // an octagon about the unit disk
    constexpr float octagon[8][2] = {{1, k},   {k, 1},   {-k, 1}, {-1, k},
                                     {-1, -k}, {-k, -1}, {k, -1}, {1, -k}};
    constexpr float corners[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    for (float t : {0.0f, 1.0f}) {
        if (p.sphere()) {
            const Vec3 c = p.origin + (t - 0.5f) * p.origin_motion;
            for (int i = 0; i < 8; ++i)
                bounds.add(camera, c + p.radius * Vec3{i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f,
                                                       i & 4 ? 1.f : -1.f});
        } else if (p.square) {
            for (const auto& c : corners) bounds.add(camera, p.point(c[0], c[1], t));
        } else {
            for (const auto& c : octagon) bounds.add(camera, p.point(c[0], c[1], t));
        }
    }
    return bounds;
}

// The plane of a patch, and what gives (a, b) of a point in it.
struct Frame {
    Vec3 normal, dual_a, dual_b;
    Frame(Vec3 side_a, Vec3 side_b) : normal(cross(side_a, side_b)) {
        const float scale = 1 / dot(normal, normal);
        dual_a = cross(side_b, normal) * scale;
        dual_b = cross(normal, side_a) * scale;
    }
};

// Where the rays meet a patch's plane: depth, or +inf where that is not nearer than what they hit
// so far or lies outside the patch's disk or square.
struct Meeting {
    alignas(64) float depth[Rays::capacity], a[Rays::capacity], b[Rays::capacity];
};

void meet_steady(const Primitive& p, const Rays& rays, Meeting& out) {
    const Frame frame(p.side_a, p.side_b);
    const Vec3 n = frame.normal, da = frame.dual_a, db = frame.dual_b, o = p.origin,
               m = p.origin_motion;
    const float limit = p.square ? 2.0f : 1.0f;
    for (int i = 0; i < rays.count; ++i) {
        const float s = rays.time[i];
        const float ox = o.x + s * m.x - rays.lens_x[i], oy = o.y + s * m.y - rays.lens_y[i],
                    oz = o.z + s * m.z;
        const float depth =
            (n.x * ox + n.y * oy + n.z * oz) / (n.x * rays.x[i] + n.y * rays.y[i] + n.z);
        const float x = depth * rays.x[i] - ox, y = depth * rays.y[i] - oy, z = depth - oz;
        const float a = x * da.x + y * da.y + z * da.z, b = x * db.x + y * db.y + z * db.z;
        const bool met = (a * a + b * b <= limit) & (depth > near_depth) & (depth < rays.depth[i]);
        out.a[i] = a, out.b[i] = b;
        out.depth[i] = met ? depth : infinity;
    }
}

void meet_turning(const Primitive& p, const Rays& rays, Meeting& out) {
    const float limit = p.square ? 2.0f : 1.0f;
    for (int i = 0; i < rays.count; ++i) {
        const float s = rays.time[i];
        const Frame frame(p.side_a + s * p.side_a_motion, p.side_b + s * p.side_b_motion);
        const Vec3 o = p.origin + s * p.origin_motion - Vec3{rays.lens_x[i], rays.lens_y[i], 0};
        const Vec3 d{rays.x[i], rays.y[i], 1};
        const float depth = dot(frame.normal, o) / dot(frame.normal, d);
        const Vec3 r = depth * d - o;
        const float a = dot(r, frame.dual_a), b = dot(r, frame.dual_b);
        const bool met = (a * a + b * b <= limit) & (depth > near_depth) & (depth < rays.depth[i]);
        out.a[i] = a, out.b[i] = b;
        out.depth[i] = met ? depth : infinity;
    }
}

void meet_sphere(const Primitive& p, const Rays& rays, Meeting& out) {
    const Vec3 o = p.origin, m = p.origin_motion;
    const float r2 = p.radius * p.radius, inverse = 1 / p.radius;
    for (int i = 0; i < rays.count; ++i) {
        const float s = rays.time[i], dx = rays.x[i], dy = rays.y[i];
        const float ox = o.x + s * m.x - rays.lens_x[i], oy = o.y + s * m.y - rays.lens_y[i],
                    oz = o.z + s * m.z;
        const float dd = dx * dx + dy * dy + 1, od = ox * dx + oy * dy + oz;
        // The point of the ray nearest to the centre, and from there half a chord back: no
        // difference of large squares.
        const float foot = od / dd;
        const float fx = foot * dx - ox, fy = foot * dy - oy, fz = foot - oz;
        const float chord2 = (r2 - (fx * fx + fy * fy + fz * fz)) / dd;
        const float depth = foot - std::sqrt(std::max(chord2, 0.0f));
        const bool met = (chord2 > 0) & (depth > near_depth) & (depth < rays.depth[i]);
        out.a[i] = (depth * dx - ox) * inverse, out.b[i] = (depth * dy - oy) * inverse;
        out.depth[i] = met ? depth : infinity;
    }
}

// Takes over the rays that meet the primitive within its outline; whether there are any.
bool hit(const Primitive& p, size_t index, Rays& rays, Meeting& meeting) {
    if (p.sphere())
        meet_sphere(p, rays, meeting);
    else if (p.turns())
        meet_turning(p, rays, meeting);
    else
        meet_steady(p, rays, meeting);
    bool any = false;
    for (int i = 0; i < rays.count; ++i) {
        if (meeting.depth[i] == infinity) continue;
        const float a = meeting.a[i], b = meeting.b[i];
        if (p.square && (std::fabs(a) > 1 || std::fabs(b) > 1)) continue;
        if (p.outline && !p.outline(p.paint, a, b)) continue;
        rays.depth[i] = meeting.depth[i];
        rays.hit[i] = std::int32_t(index);
        rays.a[i] = a, rays.b[i] = b;
        any = true;
    }
    return any;
}

}  // namespace

Tracer::Tracer(const Scene& scene, int width, int height)
    : scene_(scene), tiles_x_((width + tile - 1) / tile), tiles_y_((height + tile - 1) / tile) {
    const size_t count = scene.primitives.size();
    std::vector<Bounds> bounds(count);
    for (size_t i = 0; i < count; ++i) {
        bounds[i] = bounds_of(scene.primitives[i], scene.camera);
        nearest_.push_back(bounds[i].nearest);
    }
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](auto a, auto b) { return nearest_[a] < nearest_[b]; });

    const auto tile_of = [](float pixel, int tiles) {
        return int(std::floor(std::clamp(pixel / tile, -1.0f, float(tiles))));
    };
    std::vector<std::vector<std::uint32_t>> lists(size_t(tiles_x_) * size_t(tiles_y_));
    for (std::uint32_t i : order) {
        const int x0 = std::max(tile_of(bounds[i].x0, tiles_x_), 0),
                  x1 = std::min(tile_of(bounds[i].x1, tiles_x_), tiles_x_ - 1);
        const int y0 = std::max(tile_of(bounds[i].y0, tiles_y_), 0),
                  y1 = std::min(tile_of(bounds[i].y1, tiles_y_), tiles_y_ - 1);
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x)
                lists[size_t(y) * size_t(tiles_x_) + size_t(x)].push_back(i);
    }
    first_.push_back(0);
    for (const auto& list : lists) {
        list_.insert(list_.end(), list.begin(), list.end());
        first_.push_back(std::uint32_t(list_.size()));
    }
}

void Tracer::trace(int tile_x, int tile_y, Rays& rays) const {
    std::fill_n(rays.depth, rays.count, infinity);
    std::fill_n(rays.hit, rays.count, -1);
    Meeting meeting;
    const size_t at = size_t(tile_y) * size_t(tiles_x_) + size_t(tile_x);
    float farthest = infinity;  // of what the rays hit so far
    for (std::uint32_t k = first_[at]; k < first_[at + 1]; ++k) {
        const std::uint32_t index = list_[k];
        if (nearest_[index] > farthest) break;
        if (hit(scene_.primitives[index], index, rays, meeting))
            farthest = *std::max_element(rays.depth, rays.depth + rays.count);
    }
}

void Tracer::trace_all(Rays& rays) const {
    std::fill_n(rays.depth, rays.count, infinity);
    std::fill_n(rays.hit, rays.count, -1);
    Meeting meeting;
    for (size_t i = 0; i < scene_.primitives.size(); ++i)
        hit(scene_.primitives[i], i, rays, meeting);
}

}  // namespace weft::analytic
