// buffer-sampler: recorded samples as a renderer: at a point, what the nearest sample has. To try
// samplers on data whose renderer is not at hand.
#include "adaptive/metrics.h"
#include "adaptive/sampler_function.h"
#include "runtime/node.h"
#include "samples/lens_shape.h"

namespace weft {
namespace {
using namespace adaptive;

struct BufferSampler {
    static void declare(Ports<BufferSampler>& node) {
        node.about("recorded samples as a renderer: radiance of the nearest one")
            .in<Samples>("samples", "xy, rgb; uv, t, light_uv become axes where it has them")
            .out<SamplerFunction>("sampler", "as coarse as the buffer");
    }

    void run(const Inputs& in, Outputs& out, Context&) const {
        const Samples& samples = in.get<Samples>("samples");
        samples.require("buffer-sampler", {"xy", "rgb"});
        const auto metrics =
            std::make_shared<Metrics>(metrics_over(samples, nullptr, "buffer-sampler"));
        SamplerFunction made;
        made.width = samples.width;
        made.height = samples.height;
        made.color_space = samples.color_space;
        made.lens = samples.lens;
        made.meta = samples.meta;
        for (size_t d = 0; d < metrics->dimensions(); ++d)
            made.axes.push_back({metrics->space.axes[d], metrics->space.extent[d]});
        auto rgb =
            std::make_shared<const std::vector<float>>(samples.rgb().begin(), samples.rgb().end());
        const int u = made.axis("u"), v = made.axis("v"), t = made.axis("t");
        made.evaluate = [metrics, rgb, u, v, t, shape = samples.lens.value_or(Lens{}),
                         shutter = shutter_of(samples.meta)](
                            const SamplerPoints& points, std::uint64_t, std::span<float> values) {
            std::vector<PointTree::Near> found;
            std::array<float, most_axes> at{};
            for (size_t i = 0; i < points.size(); ++i) {
                for (size_t d = 0; d < points.axes.size(); ++d) at[d] = points.axes[d][i];
                if (u >= 0) {
                    const auto on = on_lens(at[size_t(u)], at[size_t(v)], shape);
                    at[size_t(u)] = 0.5f * (on[0] + 1), at[size_t(v)] = 0.5f * (on[1] + 1);
                }
                if (t >= 0) at[size_t(t)] = shutter.time(at[size_t(t)]);
                for (size_t d = 0; d < points.axes.size(); ++d) at[d] *= metrics->space.extent[d];
                metrics->tree->nearest(at.data(), 1, found);
                const size_t nearest = metrics->tree->order()[found[0].place];
                std::copy_n(&(*rgb)[3 * nearest], 3, &values[3 * i]);
            }
        };
        out.set("sampler", std::move(made));
    }
};

WEFT_NODE(BufferSampler, "buffer-sampler", 1)

}  // namespace
}  // namespace weft
