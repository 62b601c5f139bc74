// structure-tensors: around each sample, a distance in which the directions are short along which
// radiance does not change. Source: after Hachisuka et al. 2008 (structure_tensors_kernel.h).
#include <fmt/format.h>

#include "adaptive/metrics.h"
#include "adaptive/structure_tensors_kernel.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

enum class Smooth { where_noisy, always, never };

struct StructureTensors {
    int neighbours = 24, averaged = 96;
    float floor = 0.001f, ridge = 1e-6f;
    Smooth smooth = Smooth::where_noisy;

    static void declare(Ports<StructureTensors>& node) {
        node.about(
                "a distance around each sample, over film, lens, time and light together, by how "
                "radiance changes among its neighbours; its determinant is 1")
            .in<Samples>("samples", "xy, rgb; uv, t, light_uv as it has them")
            .in<LeafTree>("leaves",
                          "axes and their scales; else from the samples' motion and lens, 16 px "
                          "where they have neither",
                          Need::optional)
            .out<Metrics>("tensors", "of each sample")
            .param("neighbours", &StructureTensors::neighbours,
                   {.unit = "samples",
                    .min = 3,
                    .max = 256,
                    .about = "nearest ones that a gradient is fitted to; at least three an axis "
                             "are taken, and twice as many where noise is taken off"})
            .param("averaged", &StructureTensors::averaged,
                   {.unit = "samples",
                    .min = 3,
                    .max = 1024,
                    .about = "nearest ones whose tensors are averaged"})
            .param("floor", &StructureTensors::floor,
                   {.min = 1e-6,
                    .max = 1,
                    .about =
                        "least eigenvalue over the largest: 1 makes all distances Euclidean; below "
                        "0.05 in rounds, each of which may be four times below the one before"})
            .param("ridge", &StructureTensors::ridge,
                   {.min = 0,
                    .max = 1,
                    .about = "holds gradients down where neighbours lie in a plane"})
            .choice("smooth", &StructureTensors::smooth, {"auto", "always", "never"},
                    {.about = "whether what no axis explains is taken off radiance, as far as that "
                              "predicts samples better than the nearest ones do; auto: where "
                              "adaptive-samples found such noise. For blend linear"});
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LeafTree* leaves = in.find<LeafTree>("leaves");
        samples.require("structure-tensors", {"xy", "rgb"});
        Metrics metrics = metrics_over(samples, leaves, "structure-tensors");
        metrics.vary(
            samples.rgb(),
            {std::max(size_t(neighbours), 3 * metrics.dimensions()), size_t(averaged), floor, ridge,
             smooth == Smooth::always ||
                 (smooth == Smooth::where_noisy && has_hidden_noise(samples))},
            ctx);
        out.set("tensors", std::move(metrics));
    }
};

WEFT_NODE(StructureTensors, "structure-tensors", 8)

}  // namespace
}  // namespace weft
