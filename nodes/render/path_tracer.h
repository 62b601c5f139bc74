// PathTracer: samples of a picture, by unidirectional path tracing with next-event estimation.
//   wavefront   a batch of samples goes through the stages together: rays, cutouts, textures,
//               shading, shadow rays; arrays are a worker's own and are kept, so that the steady
//               state allocates nothing
//   repeatable  a sample is a function of (scene, options, pixel, its number) and of nothing else:
//               neither batches nor tiles nor threads change a bit. Camera rays go in packets of
//               one pixel's samples, 16 k to 16 k + 15.
// Sources: Kajiya 1986; Veach 1997 (multiple importance sampling, power heuristic; Russian
// roulette).
#pragma once
#include <atomic>
#include <memory>

#include "render/camera.h"
#include "render/sample_channels.h"
#include "render/shading.h"
#include "samples/samplers.h"

namespace weft::render {

enum class Mode { path, direct, ambient_occlusion };

struct RenderOptions {
    int width = 640, height = 360;
    Mode mode = Mode::path;
    int max_depth = 8;             // bounces: 0 emission alone, 1 direct light; what goes straight
                                   // through a thin sheet has not bounced
    int roulette_depth = 3;        // bounces before paths may end by chance
    float occlusion_distance = 0;  // ambient_occlusion: how far a ray looks; 0: everywhere
    float clamp_indirect = 0;      // radiance that one path may bring at most, but for direct light
    Sampler sampler = Sampler::sobol;
    std::uint64_t seed = 1;
    ChannelSet channels;
};

// Samples first, first + 1, ... of a pixel that has `spp` in all.
struct PixelRun {
    int x = 0, y = 0;
    std::uint32_t first = 0, count = 0;
    int spp = 1;
    const SampleSequence* numbers = nullptr;  // none: the options' sampler's of this pixel
};
// Runs are cut at multiples of this, so that packets are the same wherever a cut falls.
inline constexpr std::uint32_t samples_in_packet = 16;

// Where time goes, and how many rays: of one worker.
struct RenderStatistics {
    std::uint64_t camera_rays = 0, path_rays = 0, shadow_rays = 0, samples = 0, lookups = 0;
    std::uint64_t camera_ns = 0, path_ns = 0, shadow_ns = 0, texture_ns = 0, all_ns = 0;
    void add(const RenderStatistics& other);
};

struct PathWorkspace;  // a worker's memory
struct PathWorkspaceDeleter {
    void operator()(PathWorkspace* workspace) const;
};
using PathWorkspacePointer = std::unique_ptr<PathWorkspace, PathWorkspaceDeleter>;

class PathTracer {
  public:
    // `scene` must outlive this. Warns through `ctx` of what was left out.
    PathTracer(const Scene& scene, const RenderOptions& options, Context& ctx);

    const RenderOptions& options() const { return options_; }
    const Scene& scene() const { return rays_.scene(); }
    const RayScene& rays() const { return rays_; }
    const Camera& camera() const { return camera_; }
    const Lights& lights() const { return lights_; }
    bool has_motion() const { return camera_.moving() || rays_.has_motion(); }

    // A worker's memory, from those given back or new.
    PathWorkspacePointer workspace() const;
    // Makes the samples of `runs`, in their order. Threads: one workspace each.
    void render(std::span<const PixelRun> runs, PathWorkspace& workspace, SampleBatch& out) const;
    static RenderStatistics& statistics(PathWorkspace& workspace);

    // How far, in pixels, any sample so far lay from the straight line that `motion` draws between
    // both ends of its path; 0 where that line is exact.
    float largest_deviation() const { return deviation_.load(); }

  private:
    struct Pass;  // one call of render()

    RayScene rays_;
    RenderOptions options_;
    std::unique_ptr<Textures> textures_;
    Camera camera_;
    Lights lights_;
    Shading shading_;
    mutable std::atomic<float> deviation_{0};
};

}  // namespace weft::render
