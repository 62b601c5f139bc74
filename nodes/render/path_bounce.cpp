// Where paths go on: a direction that the surface chooses, or an end by chance.
#include <algorithm>

#include "render/path_numbers.h"
#include "render/path_pass.h"

namespace weft::render {

void PathTracer::Pass::bounce(int vertex) {
    next = 0;
    for (size_t k = 0; k < alive; ++k) {
        const std::uint32_t i = w.sample[k];
        const std::uint32_t object = w.rays.object[k];
        if (object == no_object || w.shading.shades[k].light) continue;
        // Light that was looked for through a sheet must be found through it as well.
        const bool last = w.bounces[k] >= max_depth();
        if (last && !scene_rays().objects()[object].clear) continue;
        const Shade& shade = w.shading.shades[k];
        const Disk direction = numbers_of(w.sequence[i], w.index[i], vertex, bounce_pair);
        const Disk choice = numbers_of(w.sequence[i], w.index[i], vertex, choice_pair);
        const BsdfSample s =
            shade.bsdf.sample(shade.frame.to_local(shade.out), choice.u, direction.u, direction.v);
        if (!(s.value.density > 0) || (last && !s.unbent)) continue;
        const Vec3 in = unit(shade.frame.to_world(s.in));
        if (vertex == 0 && wants(ChannelId::bounce)) out.set(ChannelId::bounce, i, in);
        const bool same_side =
            (dot(shade.point.geometric, in) > 0) == (dot(shade.point.geometric, shade.out) > 0);
        if (same_side == s.through) continue;
        const Vec3 value = s.value.sum();
        Vec3 throughput = w.throughput[k] * value * (1 / s.value.density);
        if (!finite(throughput) || !(largest(throughput) > 0)) continue;
        if (w.bounces[k] >= options().roulette_depth) {
            const float stay = std::min(largest(throughput), 0.95f);
            if (unit_float(mix(w.key[k] ^ 0x5275'7373'6961'6eull)) >= stay) continue;
            throughput = throughput * (1 / stay);
        }
        const size_t m = next++;
        w.next_sample[m] = i;
        w.next_throughput[m] = throughput;
        w.next_lobe[m] = w.lobe[k];
        if (vertex == 0) {
            const auto part = [](float a, float b) { return b > 0 ? a / b : 0; };
            w.next_lobe[m] = {part(s.value.diffuse.x, value.x), part(s.value.diffuse.y, value.y),
                              part(s.value.diffuse.z, value.z)};
        }
        // What goes straight on is still the ray that left the surface before: that chose it, with
        // its density, and its lights were looked for through this sheet.
        const std::uint8_t flags = w.flags[k];
        w.next_density[m] = s.unbent ? w.density[k] : s.value.density;
        w.next_from[m] = s.unbent ? w.from[k] : shade.point.position;
        w.next_bounces[m] = w.bounces[k] + !s.unbent;
        if (s.unbent)
            w.next_flags[m] = std::uint8_t(flags | (vertex == 0 ? behind_pane : 0));
        else
            w.next_flags[m] = std::uint8_t(
                (flags & behind_pane) | (flags & straight ? 0 : indirect) |
                (s.delta ? was_delta | (flags & straight) : 0) |
                (vertex == 0 && !s.delta && wants(ChannelId::direct_unshadowed) ? unsampled : 0));
        w.next_width[m] = w.footprint[k];
        // A rough surface sees in a wide cone: its light needs no fine texture.
        const float rough = shade.roughness * shade.roughness;
        w.next_spread[m] = s.delta ? w.spread[k] : w.spread[k] + 0.25f * rough;
        w.next_rays.set(
            m, offset_origin(shade.point.position, shade.point.geometric, shade.point.error, in),
            in, 0, infinity, w.rays.time[k], every_mask);
    }
    for (size_t m = 0; m < next; ++m)
        w.key[m] = mix(w.sequence[w.next_sample[m]].key + w.index[w.next_sample[m]] +
                       (std::uint64_t(vertex + 1) << 40));
    std::swap(w.sample, w.next_sample);
    std::swap(w.throughput, w.next_throughput);
    std::swap(w.lobe, w.next_lobe);
    std::swap(w.density, w.next_density);
    std::swap(w.flags, w.next_flags);
    std::swap(w.bounces, w.next_bounces);
    std::swap(w.width, w.next_width);
    std::swap(w.spread, w.next_spread);
    std::swap(w.from, w.next_from);
    std::swap(w.rays, w.next_rays);
    alive = next;
}

}  // namespace weft::render
