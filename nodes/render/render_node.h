// What the nodes that render share: size, sampling, how light is followed.
#pragma once
#include "render/sample_plan.h"
#include "runtime/node.h"

namespace weft::render {

struct RenderNode {
    int width = 640, height = 360;
    Sampler sampler = Sampler::sobol;
    std::uint64_t seed = 1;
    Mode mode = Mode::path;
    int max_depth = 8;
    float occlusion_distance = 0, clamp_indirect = 0;

    RenderOptions options() const {
        RenderOptions o;
        o.width = width, o.height = height, o.mode = mode, o.max_depth = max_depth;
        o.occlusion_distance = occlusion_distance, o.clamp_indirect = clamp_indirect;
        o.sampler = sampler, o.seed = seed;
        return o;
    }

    template <class Node>
    static void declare_shared(Ports<Node>& node) {
        const auto of = []<class T>(T RenderNode::*field) { return static_cast<T Node::*>(field); };
        node.param("width", of(&RenderNode::width),
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .param("height", of(&RenderNode::height),
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .choice("sampler", of(&RenderNode::sampler), {"independent", "stratified", "sobol"},
                    {.about = "how samples fill pixel, lens, shutter and lights; sobol is "
                              "Owen-scrambled, neighbouring pixels share one sequence"})
            .param("seed", of(&RenderNode::seed), {.about = "another number, other samples"});
        declare_light(node);
    }
    // How light is followed.
    template <class Node>
    static void declare_light(Ports<Node>& node) {
        const auto of = []<class T>(T RenderNode::*field) { return static_cast<T Node::*>(field); };
        node.choice("mode", of(&RenderNode::mode), {"path", "direct", "ambient-occlusion"},
                    {.about = "path: all light; direct: from lights and what they hit first; "
                              "ambient-occlusion: how much of the sky a surface sees"})
            .param("max-depth", of(&RenderNode::max_depth),
                   {.unit = "bounces",
                    .min = 0,
                    .max = 1000,
                    .about = "0: only what shines itself; 1: direct light"})
            .param("clamp-indirect", of(&RenderNode::clamp_indirect),
                   {.unit = "radiance",
                    .min = 0,
                    .max = 1e9,
                    .about = "most that one path may bring of light that was scattered before it "
                             "bounced again: takes fireflies away, and what caustics have above "
                             "it; 0: no bound"})
            .param(
                "occlusion-distance", of(&RenderNode::occlusion_distance),
                {.unit = "scene",
                 .min = 0,
                 .max = 1e15,
                 .about = "ambient-occlusion: how far away things still count; 0: any distance"});
    }
};

// What a run renders with: built once, by whichever call comes first, and kept while the scene is
// the same value.
class Prepared {
  public:
    struct Made {
        Made(const Scene& scene, const RenderOptions& options, SamplePlan of_samples, Context& ctx)
            : tracer(scene, options, ctx), plan(std::move(of_samples)), workers(tracer) {}
        PathTracer tracer;
        SamplePlan plan;
        RenderWorkers workers;
    };
    template <class Make>
    std::shared_ptr<Made> get(const Scene& scene, Make&& make) {
        const std::lock_guard lock(mutex_);
        if (!made_ || scene_ != &scene) made_ = make(), scene_ = &scene;
        return made_;
    }
    void release() {
        const std::lock_guard lock(mutex_);
        made_ = nullptr, scene_ = nullptr;
    }

  private:
    std::mutex mutex_;
    const Scene* scene_ = nullptr;
    std::shared_ptr<Made> made_;
};

// Says how far samples lie from the line that `motion` draws, where that shows.
void warn_of_deviation(const PathTracer& tracer, Context& ctx);

}  // namespace weft::render
