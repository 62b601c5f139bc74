// What lies between a surface and the light that was looked for, or the sky.
#include "render/path_numbers.h"
#include "render/path_pass.h"

namespace weft::render {

void PathTracer::Pass::trace_shadows(int depth) {
    ShadowQueue& queue = w.shadows;
    const Clock clock(w.statistics.shadow_ns);
    w.statistics.shadow_rays += queue.size;
    scene_rays().occluded(queue.rays, 0, queue.size);
    if (!scene_rays().has_cutouts()) {
        for (size_t q = 0; q < queue.size; ++q)
            if (queue.rays.object[q] == no_object)
                add(queue.sample[q], depth + 1, queue.diffuse[q], queue.specular[q]);
        return;
    }
    // Of those that no solid thing stops: what has holes.
    size_t kept = 0;
    Rays& r = queue.rays;
    for (size_t q = 0; q < queue.size; ++q) {
        if (r.object[q] != no_object) continue;
        r.set(kept, r.origin(q), r.direction(q), r.near[q], r.far[q], r.time[q], cutout_mask);
        queue.sample[kept] = queue.sample[q];
        queue.diffuse[kept] = queue.diffuse[q];
        queue.specular[kept] = queue.specular[q];
        queue.key[kept++] = queue.key[q];
    }
    scene_rays().intersect(r, 0, kept);
    tracer.shading_.pass_cutouts(r, kept, w.spread, queue.key, w.shading);
    for (size_t q = 0; q < kept; ++q)
        if (r.object[q] == no_object)
            add(queue.sample[q], depth + 1, queue.diffuse[q], queue.specular[q]);
}

// How much of the sky a surface sees: one ray a sample, by the cosine.
void PathTracer::Pass::occlusion() {
    ShadowQueue& queue = w.shadows;
    queue.size = 0;
    const float reach = options().occlusion_distance > 0 ? options().occlusion_distance : infinity;
    for (size_t k = 0; k < alive; ++k) {
        const std::uint32_t i = w.sample[k];
        if (w.rays.object[k] == no_object || w.shading.shades[k].light) {
            add(i, 0, {}, white);
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
        queue.sample[q] = i;
        queue.diffuse[q] = white;
        queue.specular[q] = {};
        queue.key[q] = mix(w.key[k] ^ 0x5368'6164'6f77ull);
    }
    trace_shadows(0);
}

}  // namespace weft::render
