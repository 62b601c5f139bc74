// cross-bilateral-image: means of near pixels with like features (normal, albedo, position ...),
// and, where the colour's noise is known, of colours that this noise does not tell apart.
// Source: Eisemann and Durand 2004, Petschnigg et al. 2004 (a guide decides); Rousselle, Manzi and
// Zwicker 2013, Sec. 4 (features' own noise taken off). Departure: what passes grows with the
// feature's slope, so that it has no unit and a plane seen at an angle is one surface.
#include <cmath>

#include "filters/guides.h"

namespace weft {
namespace {

struct CrossBilateralImage : LayerChoice {
    float sigma_space = 3;
    float k_color = 0.7f;
    int patch = 1;

    static void declare(Ports<CrossBilateralImage>& node) {
        node.about(
                "edge-preserving means by distance and features, their noise taken off; and by "
                "colour, as far as its noise lets one tell, where 'variance' is linked")
            .in<Image>("image", "scene-linear; all channels are filtered")
            .in<Image>("variance", "of the noise of R G B; without it colour does not count",
                       Need::optional)
            .in<Image>("mask", mask_about, Need::optional)
            .out<Image>("image", filtered_about)
            .param(
                "sigma-space", &CrossBilateralImage::sigma_space,
                {.unit = "px", .min = 0.1, .max = 32, .about = "deviation of the spatial Gaussian"})
            .param("k-color", &CrossBilateralImage::k_color,
                   {.min = 0.01,
                    .max = 100,
                    .about = "what passes as alike, in deviations of the colour's noise"})
            .param("patch", &CrossBilateralImage::patch,
                   {.unit = "px",
                    .min = 0,
                    .max = 16,
                    .about = "radius of what is compared of colour"});
        declare_layers(node);
    }

    int radius() const { return int(std::ceil(3 * sigma_space)); }

    Cost cost(const Shapes& in) const {
        return similarity_cost(in, double((2 * radius() + 1) * (2 * radius() + 1)), patch);
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Guides guides = guides_of(in);
        kernel::Similarity by = similarity_of(guides, radius(), patch, ctx);
        by.taps = window(radius(), sigma_space);
        by.color.e = 1e-10f;
        by.color.k2 = k_color * k_color;
        if (!guides.variance) by.color.components = 0;
        add_features(guides, *this, by, ctx);
        out.set("image", picture_of(means(by, ctx), guides, by, ctx));
    }
};

WEFT_NODE(CrossBilateralImage, "cross-bilateral-image", 1);

}  // namespace
}  // namespace weft
