// gaussian-filter: a picture under a Gaussian: the control that any cleverer filter is held to.
#include "filters/gaussian_filter_kernel.h"

#include <cmath>

#include "filters/guides.h"
#include "image/image_cost.h"
#include "runtime/isa.h"

namespace weft {

std::vector<float> kernel::gaussian_taps(float sigma) {
    const int radius = int(std::ceil(3 * sigma));
    std::vector<float> taps;
    for (int d = -radius; d <= radius; ++d)
        taps.push_back(std::exp(-float(d * d) / (2 * sigma * sigma)));
    return taps;
}

namespace {

struct GaussianFilterNode {
    float sigma = 2;

    static void declare(Ports<GaussianFilterNode>& node) {
        node.about("blurs a picture by a Gaussian; at the edges weights are of what lies inside")
            .in<Image>("image", "scene-linear; all channels are filtered")
            .in<Image>("mask", mask_about, Need::optional)
            .out<Image>("image", filtered_about)
            .param("sigma", &GaussianFilterNode::sigma,
                   {.unit = "px",
                    .min = 0.1,
                    .max = 256,
                    .about = "standard deviation; cut at three of them"});
    }

    Cost cost(const Shapes& in) const {
        const double channels = double(in["image"].channels);
        return cost_like(in, "image", "image", 0, 2 * channels + 2, 12 * sigma * (channels + 1));
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Guides guides = guides_of(in);
        const kernel::Similarity by = similarity_of(guides, 0, 0, ctx);
        const std::vector<float> taps = kernel::gaussian_taps(sigma);
        kernel::Planes means(by.planes.width, by.planes.height, by.channels + 1, 0);
        const auto rows_of = [] {
            using namespace kernel;
            return WEFT_PICK(gaussian_rows);
        }();
        ctx.parallel_rows(by.planes.height, [&](Rows rows) {
            rows_of(by.planes, by.channels, taps, rows.begin, rows.end, means);
        });
        out.set("image", picture_of(means, guides, by, ctx));
    }
};

WEFT_NODE(GaussianFilterNode, "gaussian-filter", 1);

}  // namespace
}  // namespace weft
