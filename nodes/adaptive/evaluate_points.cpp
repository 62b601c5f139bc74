// evaluate-points: what a sampler says of points that somebody asks for: requests of adaptive-begin
// and adaptive-step, or of graph-sampler.
#include "adaptive/request_points.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

struct EvaluatePoints {
    static void declare(Ports<EvaluatePoints>& node) {
        node.about("radiance and features of points, by a sampler")
            .in<SamplerFunction>("sampler", "what to ask")
            .in<Samples>("points", "'point', of all its axes")
            .out<Samples>("samples", "the same samples in the same order, with rgb and features");
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const SamplerFunction& sampler = in.get<SamplerFunction>("sampler");
        Samples made = in.get<Samples>("points");
        const auto points = points_of(made, sampler.dimensions(), "evaluate-points");
        const std::vector<std::span<const float>> views(points.begin(), points.end());
        const Evaluated values = evaluate(sampler, views, 0, ctx);
        judge_broken(values.broken, made.size(), ctx);
        made.lens = sampler.lens;
        made.color_space = sampler.color_space;
        for (const JsonMember& member : sampler.meta.members)
            made.meta.set(member.key, member.value);
        made.add("rgb", 3, values.rgb);
        const size_t stride = sampler.values() - 3;
        size_t before = 0;
        for (const SamplerFeature& feature : sampler.features) {
            const auto k = size_t(feature.components);
            std::vector<float> column(k * made.size());
            for (size_t i = 0; i < made.size(); ++i)
                std::copy_n(&values.features[stride * i + before], k, &column[k * i]);
            made.add(feature.name, feature.components, std::move(column));
            before += k;
        }
        made.meta = made.meta_object();
        out.set("samples", std::move(made));
    }
};

WEFT_NODE(EvaluatePoints, "evaluate-points", 1)

}  // namespace
}  // namespace weft
