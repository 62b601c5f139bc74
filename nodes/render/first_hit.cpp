#include "render/first_hit.h"

#include <algorithm>
#include <cmath>

namespace weft::render {
namespace {

// Screen motion of a point or direction given in camera space at both ends and at `time`; how far
// the last lies from the line between the others, in pixels.
struct ScreenMotion {
    Vec3 chord;
    float deviation = 0;
};
ScreenMotion motion_between(const Camera& camera, Vec3 begin, Vec3 end, Vec3 now, float time) {
    const Vec3 p0 = camera.homogeneous(begin), p1 = camera.homogeneous(end),
               p = camera.homogeneous(now);
    ScreenMotion out{p1 - p0};
    const Vec3 line = p0 + out.chord * time;
    if (line.z > 0 && p.z > 0)
        out.deviation = std::hypot(line.x / line.z - p.x / p.z, line.y / line.z - p.y / p.z);
    return out;
}

}  // namespace

float write_first_hits(const RayScene& rays, const Camera& camera, const ChannelSet& channels,
                       const Rays& hits, const std::vector<Shade>& shades, size_t n,
                       SampleBatch& out) {
    using C = ChannelId;
    float deviation = 0;
    const auto wants = [&](C c) { return channels.has(c); };
    const auto& objects = rays.objects();
    for (size_t k = 0; k < n; ++k) {
        const float time = hits.time[k];
        if (hits.object[k] == no_object) {
            if (wants(C::z)) *out.at(C::z, k) = std::numeric_limits<float>::infinity();
            if (wants(C::light_index)) out.ids[size_t(C::light_index)][k] = no_object;
            if (wants(C::motion) && camera.moving()) {
                const Vec3 d = hits.direction(k);
                const float scale = 1 / camera.direction_to_camera(d, time).z;
                out.set(C::motion, k,
                        motion_between(camera, camera.direction_to_camera(d, 0) * scale,
                                       camera.direction_to_camera(d, 1) * scale,
                                       camera.direction_to_camera(d, time) * scale, time)
                            .chord);
            }
            continue;
        }
        const Shade& shade = shades[k];
        const SurfacePoint& p = shade.point;
        const Object& object = objects[hits.object[k]];
        if (wants(C::alpha)) *out.at(C::alpha, k) = 1;
        if (wants(C::z)) *out.at(C::z, k) = std::max(camera.to_camera(p.position, time).z, 1e-20f);
        if (wants(C::motion) && (camera.moving() || object.moving())) {
            const auto at = [&](float t) {
                return position_at(object, hits.primitive[k], hits.u[k], hits.v[k], t);
            };
            const ScreenMotion m =
                motion_between(camera, camera.to_camera(at(0), 0), camera.to_camera(at(1), 1),
                               camera.to_camera(p.position, time), time);
            out.set(C::motion, k, m.chord);
            deviation = std::max(deviation, m.deviation);
        }
        if (wants(C::z_gradient)) {
            const float* xy = out.at(C::xy, k);
            const float* uv = wants(C::uv) ? out.at(C::uv, k) : nullptr;
            const Vec2 g = camera.depth_gradient(xy[0], xy[1], uv ? uv[0] : 0, uv ? uv[1] : 0, time,
                                                 p.position, p.geometric);
            float* to = out.at(C::z_gradient, k);
            to[0] = g.x, to[1] = g.y;
        }
        if (wants(C::position)) out.set(C::position, k, p.position);
        if (wants(C::normal)) out.set(C::normal, k, shade.normal);
        if (wants(C::geometric_normal)) out.set(C::geometric_normal, k, p.geometric);
        if (wants(C::albedo)) out.set(C::albedo, k, shade.albedo);
        if (wants(C::roughness)) *out.at(C::roughness, k) = shade.roughness;
        if (wants(C::emission)) out.set(C::emission, k, shade.emission);
        if (wants(C::id))
            out.ids[size_t(C::id)][k] =
                object.light >= 0 ? 0x80000000u | unsigned(object.light) : object.id;
        if (wants(C::light_index)) out.ids[size_t(C::light_index)][k] = no_object;
    }
    return deviation;
}

void write_second_hits(const ChannelSet& channels, const Rays& hits,
                       const std::vector<Shade>& shades, std::span<const std::uint32_t> sample,
                       SampleBatch& out) {
    using C = ChannelId;
    if (!channels.has(C::position2) && !channels.has(C::normal2) && !channels.has(C::albedo2))
        return;
    for (size_t k = 0; k < sample.size(); ++k) {
        if (hits.object[k] == no_object) continue;
        if (channels.has(C::position2)) out.set(C::position2, sample[k], shades[k].point.position);
        if (channels.has(C::normal2)) out.set(C::normal2, sample[k], shades[k].normal);
        if (channels.has(C::albedo2)) out.set(C::albedo2, sample[k], shades[k].albedo);
    }
}

namespace {

// Of what ray k hits, over the shutter.
Vec3 motion_of(const RayScene& rays, const Rays& hits, size_t k) {
    const Object& object = rays.objects()[hits.object[k]];
    if (!object.moving()) return {};
    return position_at(object, hits.primitive[k], hits.u[k], hits.v[k], 1) -
           position_at(object, hits.primitive[k], hits.u[k], hits.v[k], 0);
}

}  // namespace

void write_shadow_hit(const RayScene& rays, const Rays& hits, size_t k, const SurfacePoint& point,
                      Vec3 start, const LightSample& light, const ChannelSet& channels, Rays& probe,
                      SampleBatch& out, size_t i) {
    using C = ChannelId;
    const float time = hits.time[k];
    const float far = std::isinf(light.distance) ? 2 * rays.radius() + length(start - rays.center())
                                                 : light.distance;
    probe.set(0, start + light.direction * far, -light.direction, far * 1e-4f, far * (1 - 1e-5f),
              time, solid_mask | sheer_mask);
    rays.intersect(probe, 0, 1);
    const bool stopped = probe.object[0] != no_object;
    Vec3 position = point.position, normal = point.geometric;
    if (stopped) {
        const Object& object = rays.objects()[probe.object[0]];
        const SurfacePoint seen =
            surface_at(object, probe.primitive[0], probe.u[0], probe.v[0], time);
        position = seen.position;
        normal = dot(seen.geometric, light.direction) >= 0 ? seen.geometric : -seen.geometric;
    }
    if (channels.has(C::shadow_hit)) out.set(C::shadow_hit, i, position);
    if (channels.has(C::shadow_normal)) out.set(C::shadow_normal, i, normal);
    if (channels.has(C::shadow_motion))
        out.set(C::shadow_motion, i,
                stopped ? motion_of(rays, probe, 0) : motion_of(rays, hits, k));
}

}  // namespace weft::render
