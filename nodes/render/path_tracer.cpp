#include "render/path_tracer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "render/first_hit.h"
#include "render/path_workspace.h"
#include "samples/random.h"

namespace weft::render {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// Pairs of numbers: lens, film, (time, choice of the first light), then for each vertex of the
// path.
enum Pair : std::uint32_t { lens_pair, film_pair, time_pair, vertex_pairs };
// choice: which lobe; at later vertices also which light.
enum VertexPair : std::uint32_t { light_pair, bounce_pair, choice_pair, pairs_a_vertex };
// So deep in a path good patterns no longer help: plain random numbers are cheaper.
constexpr int patterned_vertices = 4;
std::uint32_t pair_of(int depth, VertexPair pair) {
    return vertex_pairs + std::uint32_t(depth) * pairs_a_vertex + pair;
}
Disk numbers_of(const SampleSequence& sequence, std::uint32_t index, int depth, VertexPair pair) {
    if (depth < patterned_vertices) return sequence(index, pair_of(depth, pair));
    const std::uint64_t bits =
        mix(sequence.key + index + (std::uint64_t(pair_of(depth, pair)) << 32));
    return {unit_float(bits), unit_float(bits << 24)};
}

enum Flag : std::uint8_t {
    straight = 1,   // only mirrored or refracted so far: sees what the camera sees
    unsampled = 2,  // lights that could have been sampled have been, with full weight
    was_delta = 4,  // the last bounce had no density: lights are seen by it alone
};

std::uint64_t now_ns() {
    return std::uint64_t(std::chrono::steady_clock::now().time_since_epoch().count());
}
struct Clock {
    std::uint64_t& to;
    std::uint64_t start = now_ns();
    explicit Clock(std::uint64_t& sum) : to(sum) {}
    ~Clock() { to += now_ns() - start; }
};

bool finite_color(Vec3 c) {
    return finite(c);
}
// Veach's power heuristic, beta = 2: the weight of a sample of density p where q could have made
// it.
float power_weight(float p, float q) {
    if (!(p < 1e18f)) return 1;  // squares would overflow; q is negligible
    const float p2 = p * p;
    return p2 / (p2 + q * q);
}

}  // namespace

struct PathTracer::Pass {
    const PathTracer& tracer;
    std::span<const PixelRun> runs;
    PathWorkspace& w;
    SampleBatch& out;
    size_t n = 0;      // samples
    size_t alive = 0;  // paths
    size_t next = 0;

    const RenderOptions& options() const { return tracer.options_; }
    const RayScene& scene_rays() const { return tracer.rays_; }
    int max_depth() const {
        return options().mode == Mode::direct ? std::min(options().max_depth, 1)
                                              : options().max_depth;
    }
    bool wants(ChannelId c) const { return options().channels.has(c); }

    void run();
    void start_paths();
    void trace_camera();
    void trace(std::uint64_t& ns, std::uint64_t& rays);
    void shade();
    void see_emission(int depth);
    void sample_lights(int depth);
    void trace_shadows(int depth);
    void bounce(int depth);
    void occlusion();
    void finish();
    void add(std::uint32_t sample, int bounces, Vec3 diffuse, Vec3 specular);
    Vec3 sky(size_t k) const;
};

// Light that reached the first hit after one bounce is `direct`, and so is what is seen itself.
void PathTracer::Pass::add(std::uint32_t i, int bounces, Vec3 diffuse, Vec3 specular) {
    const Vec3 all = diffuse + specular;
    if (!finite_color(all)) return;
    w.radiance[i] += all;
    if (bounces <= 1) w.direct[i] += all;
    if (bounces >= 1) w.diffuse[i] += diffuse, w.specular[i] += specular;
}

void PathTracer::Pass::start_paths() {
    const Camera& camera = tracer.camera_;
    const Lens lens = camera.lens();
    const float spread = camera.pixel_spread();
    size_t i = 0;
    for (const PixelRun& run : runs) {
        const SampleSequence sequence =
            sample_sequence(options().sampler, options().seed, run.x, run.y, run.spp);
        const float last_x = std::nextafter(float(run.x + 1), 0.0f),
                    last_y = std::nextafter(float(run.y + 1), 0.0f);
        for (std::uint32_t s = 0; s < run.count; ++s, ++i) {
            const std::uint32_t index = run.first + s;
            const Disk film = sequence(index, film_pair), time = sequence(index, time_pair);
            float u = 0, v = 0;
            if (!camera.pinhole()) {
                const Disk on = sequence(index, lens_pair);
                const auto uv = on_lens(on.u, on.v, lens);
                u = uv[0], v = uv[1];
            }
            const float x = std::min(float(run.x) + film.u, last_x),
                        y = std::min(float(run.y) + film.v, last_y);
            const float t = camera.shutter().time(time.u);
            const Camera::Ray ray = camera.ray(x, y, u, v, t);
            w.rays.set(i, ray.origin, ray.direction, 0, infinity, t, every_mask);
            w.sequence[i] = sequence;
            w.index[i] = index;
            w.time[i] = t;
            w.light_choice[i] = time.v;
            w.radiance[i] = w.diffuse[i] = w.specular[i] = w.direct[i] = {};
            w.sample[i] = std::uint32_t(i);
            w.throughput[i] = white;
            w.lobe[i] = {};
            w.density[i] = 0;
            w.flags[i] = straight | was_delta;
            w.width[i] = 0;
            w.spread[i] = spread;
            w.from[i] = ray.origin;
            w.key[i] = mix(sequence.key + index);
            if (wants(ChannelId::xy))
                out.at(ChannelId::xy, i)[0] = x, out.at(ChannelId::xy, i)[1] = y;
            if (wants(ChannelId::uv))
                out.at(ChannelId::uv, i)[0] = u, out.at(ChannelId::uv, i)[1] = v;
            if (wants(ChannelId::t)) *out.at(ChannelId::t, i) = t;
        }
    }
    alive = n;
}

void PathTracer::Pass::trace_camera() {
    const Clock clock(w.statistics.camera_ns);
    w.statistics.camera_rays += n;
    size_t i = 0;
    for (const PixelRun& run : runs) {
        if (run.count >= samples_in_packet / 2)
            scene_rays().intersect_packet(w.rays, i, i + run.count);
        else
            scene_rays().intersect(w.rays, i, i + run.count);
        i += run.count;
    }
}

void PathTracer::Pass::trace(std::uint64_t& ns, std::uint64_t& rays) {
    const Clock clock(ns);
    rays += alive;
    scene_rays().intersect(w.rays, 0, alive);
}

void PathTracer::Pass::shade() {
    if (scene_rays().has_cutouts())
        tracer.shading_.pass_cutouts(w.rays, alive, w.spread, w.key, w.shading);
    for (size_t k = 0; k < alive; ++k) {
        w.footprint[k] = w.width[k] + w.spread[k] * w.rays.distance[k];
        w.random[k] = unit_float(w.key[k]);
    }
    tracer.shading_.shade(w.rays, alive, w.footprint, w.random, w.shading);
}

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

void PathTracer::Pass::see_emission(int depth) {
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
        add(i, depth, diffuse, light - diffuse);
        if (depth <= 1 && wants(ChannelId::direct_unshadowed) && finite_color(light)) {
            float* to = out.at(ChannelId::direct_unshadowed, i);
            to[0] += light.x, to[1] += light.y, to[2] += light.z;
        }
    }
}

void PathTracer::Pass::sample_lights(int depth) {
    const Lights& lights = tracer.lights_;
    w.shadows.size = 0;
    if (lights.empty()) return;
    const bool first = depth == 0;
    const bool alone =
        first && wants(ChannelId::direct_unshadowed);  // no weight with the BSDF's samples
    for (size_t k = 0; k < alive; ++k) {
        w.light[k].density = 0;
        const std::uint32_t i = w.sample[k];
        if (w.rays.object[k] == no_object || w.shading.shades[k].light) continue;
        const Shade& shade = w.shading.shades[k];
        if (shade.bsdf.delta() && !first) continue;
        const Disk point = numbers_of(w.sequence[i], w.index[i], depth, light_pair);
        const float choice =
            first ? w.light_choice[i] : numbers_of(w.sequence[i], w.index[i], depth, choice_pair).v;
        w.light[k] = lights.sample(shade.point.position, w.rays.time[k], choice, point.u, point.v);
        LightSample& light = w.light[k];
        if (first && wants(ChannelId::light_uv))
            out.at(ChannelId::light_uv, i)[0] = point.u,
                                        out.at(ChannelId::light_uv, i)[1] = point.v;
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
        if (!finite_color(diffuse + specular)) continue;
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
        queue.sample[q] = i;
        queue.diffuse[q] = diffuse;
        queue.specular[q] = specular;
        queue.key[q] = mix(w.key[k] ^ 0x5368'6164'6f77ull);
        if (first && (wants(ChannelId::shadow_hit) || wants(ChannelId::shadow_normal) ||
                      wants(ChannelId::shadow_motion)))
            write_shadow_hit(scene_rays(), shade.point, start, light, w.rays.time[k],
                             options().channels, w.probe, out, i);
    }
}

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

void PathTracer::Pass::bounce(int depth) {
    next = 0;
    for (size_t k = 0; k < alive; ++k) {
        const std::uint32_t i = w.sample[k];
        if (w.rays.object[k] == no_object || w.shading.shades[k].light) continue;
        const Shade& shade = w.shading.shades[k];
        const Disk direction = numbers_of(w.sequence[i], w.index[i], depth, bounce_pair);
        const Disk choice = numbers_of(w.sequence[i], w.index[i], depth, choice_pair);
        const BsdfSample s =
            shade.bsdf.sample(shade.frame.to_local(shade.out), choice.u, direction.u, direction.v);
        if (!(s.value.density > 0)) continue;
        const Vec3 in = unit(shade.frame.to_world(s.in));
        if (depth == 0 && wants(ChannelId::bounce)) out.set(ChannelId::bounce, i, in);
        const bool same_side =
            (dot(shade.point.geometric, in) > 0) == (dot(shade.point.geometric, shade.out) > 0);
        if (same_side == s.through) continue;
        const Vec3 value = s.value.sum();
        Vec3 throughput = w.throughput[k] * value * (1 / s.value.density);
        if (!finite_color(throughput) || !(largest(throughput) > 0)) continue;
        if (depth >= options().roulette_depth) {
            const float stay = std::min(largest(throughput), 0.95f);
            if (unit_float(mix(w.key[k] ^ 0x5275'7373'6961'6eull)) >= stay) continue;
            throughput = throughput * (1 / stay);
        }
        const size_t m = next++;
        w.next_sample[m] = i;
        w.next_throughput[m] = throughput;
        w.next_lobe[m] = w.lobe[k];
        if (depth == 0) {
            const auto part = [](float a, float b) { return b > 0 ? a / b : 0; };
            w.next_lobe[m] = {part(s.value.diffuse.x, value.x), part(s.value.diffuse.y, value.y),
                              part(s.value.diffuse.z, value.z)};
        }
        w.next_density[m] = s.value.density;
        std::uint8_t flags = 0;
        if (s.delta)
            flags = was_delta | (w.flags[k] & straight);
        else if (depth == 0 && wants(ChannelId::direct_unshadowed))
            flags = unsampled;
        w.next_flags[m] = flags;
        w.next_width[m] = w.footprint[k];
        // A rough surface sees in a wide cone: its light needs no fine texture.
        const float rough = shade.roughness * shade.roughness;
        w.next_spread[m] = s.delta ? w.spread[k] : w.spread[k] + 0.25f * rough;
        w.next_from[m] = shade.point.position;
        w.next_rays.set(
            m, offset_origin(shade.point.position, shade.point.geometric, shade.point.error, in),
            in, 0, infinity, w.rays.time[k], every_mask);
    }
    for (size_t m = 0; m < next; ++m)
        w.key[m] = mix(w.sequence[w.next_sample[m]].key + w.index[w.next_sample[m]] +
                       (std::uint64_t(depth + 1) << 40));
    std::swap(w.sample, w.next_sample);
    std::swap(w.throughput, w.next_throughput);
    std::swap(w.lobe, w.next_lobe);
    std::swap(w.density, w.next_density);
    std::swap(w.flags, w.next_flags);
    std::swap(w.width, w.next_width);
    std::swap(w.spread, w.next_spread);
    std::swap(w.from, w.next_from);
    std::swap(w.rays, w.next_rays);
    alive = next;
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

void PathTracer::Pass::finish() {
    for (std::uint32_t i = 0; i < n; ++i) {
        if (wants(ChannelId::rgb)) out.set(ChannelId::rgb, i, w.radiance[i]);
        if (wants(ChannelId::direct)) out.set(ChannelId::direct, i, w.direct[i]);
        if (wants(ChannelId::diffuse)) out.set(ChannelId::diffuse, i, w.diffuse[i]);
        if (wants(ChannelId::specular)) out.set(ChannelId::specular, i, w.specular[i]);
    }
}

void PathTracer::Pass::run() {
    const FlushDenormals flush;
    const Clock clock(w.statistics.all_ns);
    for (const PixelRun& r : runs) n += r.count;
    w.statistics.samples += n;
    w.resize(n);
    out.reset(options().channels, n);
    start_paths();
    trace_camera();
    for (int depth = 0;; ++depth) {
        shade();
        if (depth == 0)
            w.deviation = std::max(
                w.deviation, write_first_hits(scene_rays(), tracer.camera_, options().channels,
                                              w.rays, w.shading.shades, n, out));
        if (depth == 1)
            write_second_hits(options().channels, w.rays, w.shading.shades,
                              {w.sample.data(), alive}, out);
        if (options().mode == Mode::ambient_occlusion) {
            occlusion();
            break;
        }
        see_emission(depth);
        if (depth >= max_depth()) break;
        sample_lights(depth);
        trace_shadows(depth);
        bounce(depth);
        if (alive == 0) break;
        trace(w.statistics.path_ns, w.statistics.path_rays);
    }
    finish();
    w.statistics.texture_ns = w.shading.texture_ns;
    w.statistics.lookups = w.shading.lookups;
}

PathTracer::PathTracer(const Scene& scene, const RenderOptions& options, Context& ctx)
    : rays_(scene, ctx),
      options_(options),
      textures_(scene.textures.empty() ? nullptr : open_textures(scene)),
      camera_(scene.camera, options.width, options.height),
      lights_(rays_, textures_.get()),
      shading_(rays_, lights_, textures_.get()) {
    for (const std::string& what : rays_.left_out()) ctx.warn(what + "; it is left out");
}

PathWorkspacePointer PathTracer::workspace() const {
    return PathWorkspacePointer(new PathWorkspace);
}

RenderStatistics& PathTracer::statistics(PathWorkspace& workspace) {
    return workspace.statistics;
}

void PathTracer::render(std::span<const PixelRun> runs, PathWorkspace& workspace,
                        SampleBatch& out) const {
    Pass pass{*this, runs, workspace, out};
    pass.run();
    // Largest of all, whatever the order.
    float seen = deviation_.load();
    while (workspace.deviation > seen &&
           !deviation_.compare_exchange_weak(seen, workspace.deviation)) {
    }
}

}  // namespace weft::render
