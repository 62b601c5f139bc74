// uniform-samples: the same number of points in every pixel, well spread over all axes: what
// adaptive sampling is held to.
#include <fmt/format.h>

#include "adaptive/sampled_points.h"
#include "runtime/node.h"
#include "samples/samplers.h"

namespace weft {
namespace {

struct UniformSamples {
    int per_pixel = 8;
    Sampler sequence = Sampler::sobol;
    std::uint64_t seed = 1;

    static void declare(Ports<UniformSamples>& node) {
        node.about("samples a renderer evenly: as many points in every pixel")
            .in<SamplerFunction>("sampler", "what to sample")
            .out<Samples>("samples", "xy, uv and t as it has them, its other axes, rgb")
            .param("per-pixel", &UniformSamples::per_pixel,
                   {.unit = "samples", .min = 1, .max = 1 << 20, .about = "points in a pixel"})
            .choice("sequence", &UniformSamples::sequence, {"independent", "stratified", "sobol"},
                    {.about = "how points fill pixel and axes; sobol is Owen-scrambled"})
            .param("seed", &UniformSamples::seed,
                   {.min = 0, .about = "another number, other points"});
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const SamplerFunction& sampler = in.get<SamplerFunction>("sampler");
        const size_t axes = sampler.dimensions(), spp = size_t(per_pixel),
                     n = sampler.pixels() * spp;
        if (n > 0xffffffffu)
            ctx.fail(
                fmt::format("{} samples are more than the 4294967295 that a buffer of points can "
                            "hold; ask for fewer a pixel",
                            n));
        std::vector<std::vector<float>> points(axes, std::vector<float>(n));
        ctx.parallel_rows(sampler.height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < sampler.width; ++x) {
                    const SampleSequence numbers = sample_sequence(sequence, seed, x, y, per_pixel);
                    const size_t first = (size_t(y) * size_t(sampler.width) + size_t(x)) * spp;
                    for (size_t i = 0; i < spp; ++i)
                        for (size_t d = 0; d < axes; d += 2) {
                            const Disk pair = numbers(std::uint32_t(i), std::uint32_t(d / 2));
                            points[d][first + i] =
                                d == 0 ? (float(x) + pair.u) / float(sampler.width) : pair.u;
                            if (d + 1 < axes)
                                points[d + 1][first + i] =
                                    d == 0 ? (float(y) + pair.v) / float(sampler.height) : pair.v;
                        }
                }
        });
        const std::vector<std::span<const float>> views(points.begin(), points.end());
        const adaptive::Evaluated values = adaptive::evaluate(sampler, views, 0, ctx);
        adaptive::judge_broken(values.broken, n, ctx);
        std::vector<std::uint32_t> order;
        out.set("samples", adaptive::samples_of(sampler, views, values, {}, order));
    }
};

WEFT_NODE(UniformSamples, "uniform-samples", 1)

}  // namespace
}  // namespace weft
