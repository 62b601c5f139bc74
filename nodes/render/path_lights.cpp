// Light that a path meets, and light that is looked for: two ways to the same light, weighed so
// that together they count it once. Source: Veach 1997, Sec. 9.2.
#include <cmath>

#include "render/first_hit.h"
#include "render/path_numbers.h"
#include "render/path_pass.h"

namespace weft::render {
namespace {

// Veach's power heuristic, beta = 2: the weight of a sample of density p where q could have made
// it.
float power_weight(float p, float q) {
    if (!(p < 1e18f)) return 1;  // squares would overflow; q is negligible
    const float p2 = p * p;
    return p2 / (p2 + q * q);
}

}  // namespace

// What a ray that hits nothing sees.
Vec3 PathTracer::Pass::sky(size_t k) const {
    const EnvironmentLight& environment = tracer.lights_.environment();
    if (!environment.present() || ((w.flags[k] & straight) && !environment.visible())) return {};
    const Vec3 direction = w.rays.direction(k);
    float weight = 1;
    if (!(w.flags[k] & was_delta)) {
        const float other = tracer.lights_.environment_density(direction);
        if (other > 0) weight = (w.flags[k] & unsampled) ? 0 : power_weight(w.density[k], other);
    }
    return environment.radiance(direction) * weight;
}

void PathTracer::Pass::see_emission() {
    for (size_t k = 0; k < alive; ++k) {
        const std::uint32_t i = w.sample[k], object = w.rays.object[k];
        Vec3 light;
        if (object == no_object) {
            light = sky(k);
        } else {
            light = w.shading.shades[k].emission;
            if (light == Vec3{}) continue;
            if (!(w.flags[k] & was_delta)) {
                const float other =
                    tracer.lights_.density(w.from[k], w.rays.time[k], object, w.rays.primitive[k],
                                           w.rays.u[k], w.rays.v[k]);
                if (other > 0)
                    light =
                        light * ((w.flags[k] & unsampled) ? 0 : power_weight(w.density[k], other));
            }
        }
        light = light * w.throughput[k];
        const Vec3 diffuse = light * w.lobe[k];
        const int bounces = bounces_seen(k);
        add({i, std::uint8_t(std::min(bounces, 2)), (w.flags[k] & indirect) != 0, diffuse,
             light - diffuse});
        if (bounces <= 1 && wants(ChannelId::direct_unshadowed) && finite(light)) {
            float* to = out.at(ChannelId::direct_unshadowed, i);
            to[0] += light.x, to[1] += light.y, to[2] += light.z;
        }
    }
}

void PathTracer::Pass::sample_lights(int vertex) {
    const Lights& lights = tracer.lights_;
    w.shadows.size = 0;
    if (lights.empty()) return;
    const bool first = vertex == 0;
    const bool alone =
        first && wants(ChannelId::direct_unshadowed);  // no weight with the BSDF's samples
    for (size_t k = 0; k < alive; ++k) {
        w.light[k].density = 0;
        const std::uint32_t i = w.sample[k];
        if (w.rays.object[k] == no_object || w.shading.shades[k].light) continue;
        if (w.bounces[k] >= max_depth()) continue;
        const Shade& shade = w.shading.shades[k];
        if (shade.bsdf.delta() && !first) continue;
        const Disk point = numbers_of(w.sequence[i], w.index[i], vertex, light_pair);
        const float choice = first ? w.light_choice[i]
                                   : numbers_of(w.sequence[i], w.index[i], vertex, choice_pair).v;
        w.light[k] = lights.sample(shade.point.position, w.rays.time[k], choice, point.u, point.v);
        LightSample& light = w.light[k];
        if (first && wants(ChannelId::light_uv))
            out.at(ChannelId::light_uv, i)[0] = point.u,
                                        out.at(ChannelId::light_uv, i)[1] = point.v;
        if (first && wants(ChannelId::light_point) && std::isfinite(light.distance))
            out.set(ChannelId::light_point, i,
                    shade.point.position + light.direction * light.distance);
        if (first && wants(ChannelId::light_index))
            out.ids[size_t(ChannelId::light_index)][i] = light.light;
        if (!(light.density > 0) || shade.bsdf.delta()) {
            light.density = 0;
            continue;
        }
        const Vec3 to_out = shade.frame.to_local(shade.out),
                   to_light = shade.frame.to_local(light.direction);
        // Light must come through the true surface where it does through the shading normal's.
        const bool same_side = (dot(shade.point.geometric, light.direction) > 0) ==
                               (dot(shade.point.geometric, shade.out) > 0);
        if (same_side != (to_out.z * to_light.z > 0)) {
            light.density = 0;
            continue;
        }
        w.light_value[k] = shade.bsdf.eval(to_out, to_light);
        if (!(largest(w.light_value[k].sum()) > 0)) light.density = 0;
    }
    tracer.shading_.light_radiance({w.light.data(), alive}, w.shading);

    ShadowQueue& queue = w.shadows;
    for (size_t k = 0; k < alive; ++k) {
        const LightSample& light = w.light[k];
        if (!(light.density > 0)) continue;
        const std::uint32_t i = w.sample[k];
        const Shade& shade = w.shading.shades[k];
        const BsdfValue& value = w.light_value[k];
        const float weight = light.delta || alone ? 1 : power_weight(light.density, value.density);
        const Vec3 arriving = w.throughput[k] * light.radiance * (weight / light.density);
        Vec3 diffuse = arriving * value.diffuse, specular = arriving * value.specular;
        if (!first) {
            const Vec3 all = diffuse + specular;
            diffuse = all * w.lobe[k];
            specular = all - diffuse;
        }
        if (!finite(diffuse + specular)) continue;
        if (alone) {
            float* to = out.at(ChannelId::direct_unshadowed, i);
            const Vec3 all = diffuse + specular;
            to[0] += all.x, to[1] += all.y, to[2] += all.z;
        }
        const Vec3 start = offset_origin(shade.point.position, shade.point.geometric,
                                         shade.point.error, light.direction);
        // To the light's point from where the ray starts, or the light itself would stand in its
        // way.
        Vec3 direction = light.direction;
        float reach = infinity;
        if (std::isfinite(light.distance)) {
            const Vec3 way = shade.point.position + light.direction * light.distance - start;
            const float distance = length(way);
            if (!(distance > 0)) continue;
            direction = way * (1 / distance);
            reach = distance * (1 - 1e-4f);
        }
        const size_t q = queue.size++;
        queue.rays.set(q, start, direction, 0, reach, w.rays.time[k], solid_mask | light_mask);
        queue.light[q] = {i,
                          std::uint8_t(std::min(bounces_seen(k) + 1, 2)),
                          (w.flags[k] & straight) == 0,
                          diffuse,
                          specular,
                          shadow_key(w.key[k])};
        if (first && (wants(ChannelId::shadow_hit) || wants(ChannelId::shadow_normal) ||
                      wants(ChannelId::shadow_motion)))
            write_shadow_hit(scene_rays(), w.rays, k, shade.point, start, light,
                             options().channels, w.probe, out, i);
    }
}

}  // namespace weft::render
