// structure-tensors: around each sample, a distance in which the directions are short along which
// radiance does not change. Source: after Hachisuka et al. 2008 (structure_tensors_kernel.h).
#include <fmt/format.h>

#include "adaptive/metrics.h"
#include "adaptive/structure_tensors_kernel.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

struct StructureTensors {
    int neighbours = 48;
    float floor = 0.05f, ridge = 1e-6f;

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
                             "are taken"})
            .param("floor", &StructureTensors::floor,
                   {.min = 1e-6,
                    .max = 1,
                    .about = "least eigenvalue over the largest: 1 makes all distances Euclidean"})
            .param("ridge", &StructureTensors::ridge,
                   {.min = 0,
                    .max = 1,
                    .about = "holds gradients down where neighbours lie in a plane"});
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LeafTree* leaves = in.find<LeafTree>("leaves");
        samples.require("structure-tensors", {"xy", "rgb"});
        Metrics metrics = metrics_over(samples, leaves, "structure-tensors");
        const PointTree& tree = *metrics.tree;
        std::vector<float> rgb;
        rgb.reserve(3 * samples.size());
        for (const std::uint32_t i : tree.order())
            rgb.insert(rgb.end(), &samples.rgb()[3 * size_t(i)], &samples.rgb()[3 * size_t(i)] + 3);
        TensorSettings settings{std::max(size_t(neighbours), 3 * metrics.dimensions()), floor,
                                ridge};
        const auto slopes = gradients(tree, rgb, settings, ctx);
        metrics.upper = structure_metrics(tree, rgb, slopes, settings, ctx);
        out.set("tensors", std::move(metrics));
    }
};

WEFT_NODE(StructureTensors, "structure-tensors", 1)

}  // namespace
}  // namespace weft
