// What lies between a surface and the light that was looked for, or the sky.
#include <utility>

#include "render/path_numbers.h"
#include "render/path_pass.h"

namespace weft::render {

void PathTracer::Pass::trace_shadows() {
    ShadowQueue& queue = w.shadows;
    const Clock clock(w.statistics.shadow_ns);
    w.statistics.shadow_rays += queue.size;
    Rays& rays = queue.rays;
    scene_rays().occluded(rays, 0, queue.size);
    size_t kept = 0;
    const auto keep = [&](size_t q, float near) {
        rays.set(kept, rays.origin(q), rays.direction(q), near, rays.far[q], rays.time[q],
                 sheer_mask);
        queue.light[kept++] = queue.light[q];
    };
    const bool sheer = scene_rays().has_cutouts() || scene_rays().has_clear();
    for (size_t q = 0; q < queue.size; ++q) {
        if (rays.object[q] != no_object) continue;
        if (sheer)
            keep(q, rays.near[q]);
        else
            add(queue.light[q]);
    }
    // No solid thing stops these: each sheet that they meet takes its part.
    for (int layer = 0; layer < most_layers && kept > 0; ++layer) {
        const size_t size = std::exchange(kept, 0);
        scene_rays().intersect(rays, 0, size);
        for (size_t q = 0; q < size; ++q)
            queue.random[q] = unit_float(mix(queue.light[q].key + std::uint64_t(layer)));
        tracer.shading_.transmittance(rays, size, tracer.camera_.pixel_spread(), queue.random,
                                      queue.part, queue.shading);
        for (size_t q = 0; q < size; ++q) {
            Arriving& light = queue.light[q];
            if (rays.object[q] == no_object) {
                add(light);
                continue;
            }
            light.diffuse = light.diffuse * queue.part[q];
            light.specular = light.specular * queue.part[q];
            if (largest(light.diffuse + light.specular) > 0)
                keep(q, beyond(rays.distance[q], queue.shading.shades[q].point.error));
        }
    }
}

// How much of the sky a surface sees: one ray a sample, by the cosine.
void PathTracer::Pass::occlusion() {
    ShadowQueue& queue = w.shadows;
    queue.size = 0;
    const float reach = options().occlusion_distance > 0 ? options().occlusion_distance : infinity;
    for (size_t k = 0; k < alive; ++k) {
        const std::uint32_t i = w.sample[k];
        if (w.rays.object[k] == no_object || w.shading.shades[k].light) {
            add({i, 0, false, {}, white});
            continue;
        }
        const Shade& shade = w.shading.shades[k];
        const Disk d = w.sequence[i](w.index[i], pair_of(0, bounce_pair));
        const bool front = dot(shade.normal, shade.out) > 0;
        const Vec3 local = cosine_direction(d.u, d.v),
                   in = shade.frame.to_world(front ? local : -local);
        if (wants(ChannelId::bounce)) out.set(ChannelId::bounce, i, in);
        const size_t q = queue.size++;
        queue.rays.set(
            q, offset_origin(shade.point.position, shade.point.geometric, shade.point.error, in),
            in, 0, reach, w.rays.time[k], solid_mask);
        queue.light[q] = {i, 1, false, white, {}, shadow_key(w.key[k])};
    }
    trace_shadows();
}

}  // namespace weft::render
