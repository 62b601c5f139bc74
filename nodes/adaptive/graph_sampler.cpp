// graph-sampler: a graph as a renderer: what it makes of points is what a sampler says of them.
// asked-points stands for these points in such a graph.
#include "adaptive/graph_function.h"
#include "adaptive/request_points.h"
#include "adaptive/sampler_shape.h"

namespace weft {
namespace {
using namespace adaptive;

struct GraphSampler : SamplerShape {
    InputFile graph;
    Json set = Json::object();
    std::vector<std::string> features;

    static void declare(Ports<GraphSampler>& node) {
        node.about(
                "a graph as a renderer to sample: a document with an input 'points' and an output "
                "'samples', whose rgb is the radiance of each point")
            .out<SamplerFunction>("sampler", "the graph, asked for batches of points")
            .param("graph", &GraphSampler::graph,
                   {.about = "the document; its nodes work on whole values", .required = true})
            .param("set", &GraphSampler::set, {.about = "its parameters: {\"name\": value}"})
            .param("features", &GraphSampler::features,
                   {.about = "channels of its output to hand on, by their standard names"});
        declare_shape(node);
    }
    void run(const Inputs&, Outputs& out, Context& ctx) const {
        SamplerFunction made = sampler();
        made.features = standard_features(features);
        made.meta.set("source", "graph-sampler");
        const auto function = std::make_shared<const GraphFunction>(graph.path, set, ctx);
        made.evaluate = [function, shape = made](const SamplerPoints& points, std::uint64_t,
                                                 std::span<float> values) {
            const size_t n = points.size(), stride = shape.values();
            const std::vector<std::span<const float>> at(points.axes.begin(), points.axes.end());
            const Samples answers = (*function)(request_points(shape, at, 0));
            const Evaluated got = answers_of(answers, shape.features, 0, n);
            for (size_t i = 0; i < n; ++i) {
                std::copy_n(&got.rgb[3 * i], 3, &values[stride * i]);
                if (stride > 3)
                    std::copy_n(&got.features[(stride - 3) * i], stride - 3,
                                &values[stride * i + 3]);
            }
        };
        out.set("sampler", std::move(made));
    }
};

struct AskedPoints {
    static void declare(Ports<AskedPoints>& node) {
        node.about("the points that graph-sampler asks its graph for; it puts this node there")
            .out<Samples>("points", "xy, uv, t ..., 'point' in [0, 1], 'request' numbers");
    }
    void run(const Inputs&, Outputs&, Context& ctx) const {
        ctx.fail("nobody asks for points here; let graph-sampler read this graph");
    }
};

WEFT_NODE(GraphSampler, "graph-sampler", 1)
WEFT_NODE(AskedPoints, "asked-points", 1)

}  // namespace
}  // namespace weft
