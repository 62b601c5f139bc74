// scene-sampler: the path tracer as a function of points. Axes that are explicit take the place of
// its random numbers; what remains comes from a hash of the point.
//   x y u v t          film, lens, shutter
//   light-u light-v    the point on the light that the first hit looks for; light: which light
//   bounce-u bounce-v  the direction in which the first hit's path goes on; of ambient occlusion
//                      the only one
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <bit>
#include <cmath>

#include "adaptive/sampler_function.h"
#include "adaptive/scaled_space.h"
#include "render/path_numbers.h"
#include "render/render_samples_node.h"
#include "render/sample_buffer.h"

namespace weft {
namespace {
using namespace render;

struct AxisPair {
    const char* name;
    std::uint32_t pair;
    bool second;
};
constexpr AxisPair known_axes[] = {
    {"x", film_pair, false},
    {"y", film_pair, true},
    {"u", lens_pair, false},
    {"v", lens_pair, true},
    {"t", time_pair, false},
    {"light", time_pair, true},
    {"light-u", pair_of(0, light_pair), false},
    {"light-v", pair_of(0, light_pair), true},
    {"bounce-u", pair_of(0, bounce_pair), false},
    {"bounce-v", pair_of(0, bounce_pair), true},
};
constexpr std::uint32_t pairs_given = pair_of(0, pairs_a_vertex);

// A scene, its path tracer and which numbers of a path the axes are.
class ScenePoints {
  public:
    ScenePoints(const Scene& scene, const RenderOptions& options, std::vector<AxisPair> axes,
                Context& ctx)
        : scene_(scene), tracer_(scene_, options, ctx), workers_(tracer_), axes_(std::move(axes)) {
        for (const ChannelId c : tracer_.options().channels.list())
            if (c != ChannelId::rgb && c != ChannelId::xy && !info_of(c).whole)
                features_.push_back(c);
    }
    const PathTracer& tracer() const { return tracer_; }
    const std::vector<ChannelId>& features() const { return features_; }

    void evaluate(const SamplerPoints& points, std::uint64_t hidden_seed, std::span<float> values) {
        workers_.with([&](RenderWorker& worker) {
            for (size_t begin = 0; begin < points.size(); begin += samples_in_batch)
                batch(points, begin, std::min(begin + samples_in_batch, points.size()), hidden_seed,
                      worker, values);
        });
    }

  private:
    void batch(const SamplerPoints& points, size_t begin, size_t end, std::uint64_t hidden_seed,
               RenderWorker& worker, std::span<float> values) {
        const int width = tracer_.options().width, height = tracer_.options().height;
        std::vector<std::array<Disk, pairs_given>> given(end - begin);
        std::vector<SampleSequence> numbers(end - begin);
        std::uint32_t chosen = 0;
        for (const AxisPair& axis : axes_) chosen |= 1u << axis.pair;
        worker.runs.clear();
        for (size_t i = begin; i < end; ++i) {
            std::uint64_t key = mix(tracer_.options().seed + mix(hidden_seed));
            for (const auto& axis : points.axes)
                key = mix(key ^ std::bit_cast<std::uint32_t>(axis[i]));
            auto& pairs = given[i - begin];
            for (std::uint32_t p = 0; p < pairs_given; ++p) {
                const std::uint64_t bits = mix(key + p);
                pairs[p] = {unit_float(bits), unit_float(bits << 24)};
            }
            for (size_t d = 0; d < axes_.size(); ++d)
                (axes_[d].second ? pairs[axes_[d].pair].v : pairs[axes_[d].pair].u) =
                    points.axes[d][i];
            const float x = points.axes[0][i] * float(width), y = points.axes[1][i] * float(height);
            const int px = std::min(int(x), width - 1), py = std::min(int(y), height - 1);
            pairs[film_pair] = {x - float(px), y - float(py)};
            SampleSequence& sequence = numbers[i - begin];
            sequence.key = key;
            sequence.given_pairs = chosen;
            sequence.given = pairs.data();
            worker.runs.push_back({px, py, 0, 1, 1, &sequence});
        }
        tracer_.render(worker.runs, *worker.workspace, worker.batch);
        size_t stride = 3;
        for (const ChannelId c : features_) stride += size_t(info_of(c).components);
        for (size_t i = begin; i < end; ++i) {
            float* to = &values[stride * i];
            to = std::copy_n(worker.batch.at(ChannelId::rgb, i - begin), 3, to);
            for (const ChannelId c : features_)
                to = std::copy_n(worker.batch.at(c, i - begin), info_of(c).components, to);
        }
    }

    Scene scene_;  // its own: a value lives only until its last reader has read it
    PathTracer tracer_;
    RenderWorkers workers_;
    std::vector<AxisPair> axes_;
    std::vector<ChannelId> features_;
};

struct SceneSampler : RenderSamplesNode {
    std::vector<std::string> axes{"auto"};

    static void declare(Ports<SceneSampler>& node) {
        node.about("the path tracer as a function of film, lens, time, light and direction")
            .in<Scene>("scene", "what to render, from its camera")
            .out<SamplerFunction>("sampler", "radiance and the channels asked for, at points")
            .param("axes", &SceneSampler::axes,
                   {.about = "which numbers of a path are explicit, beside x and y: u v t light "
                             "light-u light-v bounce-u bounce-v; auto: lens and time where they "
                             "matter, bounce-u and bounce-v of ambient occlusion"})
            .param(
                "channels",
                static_cast<std::vector<std::string> SceneSampler::*>(&RenderSamplesNode::channels),
                {.about = "names as in sample files; basic: uv t z motion alpha; all: "
                          "everything but whole numbers"});
        const auto of = []<class T>(T RenderNode::*field) {
            return static_cast<T SceneSampler::*>(field);
        };
        node.param("width", of(&RenderNode::width),
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .param("height", of(&RenderNode::height),
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .param("seed", of(&RenderNode::seed), {.about = "of what the axes leave open"});
        declare_light(node);
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Scene& scene = in.get<Scene>("scene");
        RenderOptions o = options();
        o.channels = channels_of(scene);
        const bool moves = o.channels.has(ChannelId::t) || channel_set_moves(scene),
                   lens = scene.camera.lens_radius > 0;
        auto points = std::make_shared<ScenePoints>(scene, o, chosen_axes(lens, moves, ctx), ctx);

        SamplerFunction function;
        function.width = width;
        function.height = height;
        function.color_space = scene.color_space;
        const SamplePlan one(width, height, 1);
        const Samples head = empty_samples(points->tracer(), one);
        function.lens = head.lens;
        function.meta = head.meta;
        for (const ChannelId c : points->features())
            function.features.push_back({std::string(info_of(c).name), info_of(c).components});
        for (const AxisPair& axis : chosen_axes(lens, moves, ctx))
            function.axes.push_back({axis.name, 0});
        function.evaluate = [points](const SamplerPoints& at, std::uint64_t hidden_seed,
                                     std::span<float> values) {
            points->evaluate(at, hidden_seed, values);
        };
        scale_axes(scene, head, function, ctx);
        out.set("sampler", std::move(function));
    }

  private:
    static bool channel_set_moves(const Scene& scene) {
        RenderSamplesNode basic;
        return basic.channels_of(scene).has(ChannelId::t);
    }
    std::vector<AxisPair> chosen_axes(bool lens, bool moves, Context& ctx) const {
        std::vector<AxisPair> chosen(known_axes, known_axes + 2);
        std::vector<std::string> wanted;
        for (const std::string& name : axes) {
            if (name != "auto") {
                wanted.push_back(name);
                continue;
            }
            if (lens) wanted.insert(wanted.end(), {"u", "v"});
            if (moves) wanted.emplace_back("t");
            if (mode == Mode::ambient_occlusion)
                wanted.insert(wanted.end(), {"bounce-u", "bounce-v"});
        }
        for (const std::string& name : wanted) {
            const auto same = [&](const AxisPair& axis) { return name == axis.name; };
            const auto* found = std::find_if(std::begin(known_axes), std::end(known_axes), same);
            if (found == std::end(known_axes))
                ctx.fail(
                    fmt::format("no axis '{}'; there are auto, u, v, t, light, light-u, "
                                "light-v, bounce-u, bounce-v",
                                name));
            if (std::find_if(chosen.begin(), chosen.end(), same) == chosen.end())
                chosen.push_back(*found);
        }
        return chosen;
    }
    // How far the picture moves over lens and shutter, by some thousand points all over it.
    void scale_axes(const Scene& scene, const Samples& head, SamplerFunction& function,
                    Context& ctx) const {
        constexpr size_t n = 4096;
        RenderOptions o = options();
        o.max_depth = 0;
        const std::vector<std::string> names{"basic", "t", "motion"};
        o.channels = channel_set(names, scene.camera.lens_radius > 0, true);
        PathTracer tracer(scene, o, ctx);
        PathWorkspacePointer workspace = tracer.workspace();
        SampleBatch batch;
        std::vector<PixelRun> runs;
        for (size_t i = 0; i < n; ++i) {
            const Disk at = sample_sequence(Sampler::sobol, 1, 0, 0, int(n))(std::uint32_t(i), 0);
            runs.push_back({std::min(int(at.u * float(width)), width - 1),
                            std::min(int(at.v * float(height)), height - 1), 0, 1, 1, nullptr});
        }
        tracer.render(runs, *workspace, batch);
        Samples seen = head;
        seen.set_size(n);
        for (const ChannelId c : o.channels.list())
            seen.add(std::string(info_of(c).name), info_of(c).components,
                     std::vector<float>(batch.values[size_t(c)]));
        for (SamplerAxis& axis : function.axes) {
            if (axis.name == "x") axis.scale = float(width);
            if (axis.name == "y") axis.scale = float(height);
            if (axis.name == "u" || axis.name == "v")
                axis.scale = std::max(1.0f, adaptive::median_defocus(seen));
            if (axis.name == "t") axis.scale = adaptive::median_motion(seen);
        }
    }
};

WEFT_NODE(SceneSampler, "scene-sampler", 1)

}  // namespace
}  // namespace weft
