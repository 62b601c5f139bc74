#include "render/path_tracer.h"

#include <fmt/format.h>

#include <algorithm>

#include "render/first_hit.h"
#include "render/path_pass.h"
#include "samples/random.h"

namespace weft::render {

// Light that reached the first hit after one bounce is `direct`, and so is what is seen itself.
void PathTracer::Pass::add(const Arriving& light) {
    const Vec3 all = light.diffuse + light.specular;
    if (!finite(all)) return;
    float part = 1;
    const float most = options().clamp_indirect;
    if (light.indirect && most > 0 && largest(all) > most) part = most / largest(all);
    const std::uint32_t i = light.sample;
    w.radiance[i] += all * part;
    if (light.bounces <= 1) w.direct[i] += all * part;
    if (light.bounces >= 1)
        w.diffuse[i] += light.diffuse * part, w.specular[i] += light.specular * part;
}

void PathTracer::Pass::trace(std::uint64_t& ns, std::uint64_t& rays) {
    const Clock clock(ns);
    rays += alive;
    scene_rays().intersect(w.rays, 0, alive);
}

void PathTracer::Pass::shade() {
    if (scene_rays().has_cutouts())
        tracer.shading_.pass_cutouts(w.rays, alive, tracer.camera_.pixel_spread(), w.key,
                                     w.shading);
    for (size_t k = 0; k < alive; ++k) {
        w.footprint[k] = w.width[k] + w.spread[k] * w.rays.distance[k];
        w.random[k] = unit_float(w.key[k]);
    }
    tracer.shading_.shade(w.rays, alive, w.footprint, w.random, w.shading);
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
    for (int vertex = 0;; ++vertex) {
        shade();
        if (vertex == 0)
            w.deviation = std::max(
                w.deviation, write_first_hits(scene_rays(), tracer.camera_, options().channels,
                                              w.rays, w.shading.shades, n, out));
        if (vertex == 1)
            write_second_hits(options().channels, w.rays, w.shading.shades,
                              {w.sample.data(), alive}, out);
        if (options().mode == Mode::ambient_occlusion) {
            occlusion();
            break;
        }
        see_emission();
        if (vertex >= max_depth() + (scene_rays().has_clear() ? most_layers : 0)) break;
        sample_lights(vertex);
        trace_shadows();
        bounce(vertex);
        if (alive == 0) break;
        trace(w.statistics.path_ns, w.statistics.path_rays);
    }
    finish();
    w.statistics.texture_ns = w.shading.texture_ns + w.shadows.shading.texture_ns;
    w.statistics.lookups = w.shading.lookups + w.shadows.shading.lookups;
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
