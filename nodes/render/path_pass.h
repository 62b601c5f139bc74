// PathTracer::Pass: one call of PathTracer::render().
#pragma once
#include <chrono>

#include "render/path_workspace.h"

namespace weft::render {

enum PathFlag : std::uint8_t {
    straight = 1,      // only mirrored or refracted so far: sees what the camera sees
    unsampled = 2,     // lights that could have been sampled have been, with full weight
    was_delta = 4,     // the last bounce had no density: lights are seen by it alone
    indirect = 8,      // scattered, and bounced again since
    behind_pane = 16,  // went straight through the first hit
};

inline std::uint64_t now_ns() {
    return std::uint64_t(std::chrono::steady_clock::now().time_since_epoch().count());
}
struct Clock {
    std::uint64_t& to;
    std::uint64_t start = now_ns();
    explicit Clock(std::uint64_t& sum) : to(sum) {}
    ~Clock() { to += now_ns() - start; }
};

// A batch on its way through the stages. Each stage goes through all paths alive; path k is of
// sample w.sample[k]. `vertex` counts the hits of the longest paths, from 0: sheets that a path
// goes straight through are vertices, but no bounces. Where a stage is defined:
//   path_camera.cpp   start_paths, trace_camera
//   path_lights.cpp   see_emission, sky, sample_lights
//   path_shadows.cpp  trace_shadows, occlusion
//   path_bounce.cpp   bounce
//   path_tracer.cpp   run, which calls them, and what remains
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
    void see_emission();
    void sample_lights(int vertex);
    void trace_shadows();
    void bounce(int vertex);
    void occlusion();
    void finish();
    void add(const Arriving& light);
    // Bounces of path k, as channels count them: a sheet at the first hit is one.
    int bounces_seen(size_t k) const { return w.bounces[k] + ((w.flags[k] & behind_pane) != 0); }
    Vec3 sky(size_t k) const;
};

}  // namespace weft::render
