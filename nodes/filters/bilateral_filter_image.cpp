// bilateral-filter-image: means of near pixels of like colour. On Monte Carlo noise it fails, and
// shows why features are wanted: a noisy pixel is unlike its neighbours, and so it stays.
// Source: Tomasi and Manduchi 1998, Sec. 2; window cut at three standard deviations.
#include <cmath>

#include "filters/guides.h"

namespace weft {
namespace {

struct BilateralFilterImage {
    float sigma_space = 3, sigma_color = 0.2f, sigma_noise = 1;

    static void declare(Ports<BilateralFilterImage>& node) {
        node.about("edge-preserving means by distance and colour alone")
            .in<Image>("image", "scene-linear; all channels are filtered, R G B compared")
            .in<Image>("variance",
                       "of the noise of these values, channels alike; with it colours are compared "
                       "in deviations of their noise",
                       Need::optional)
            .in<Image>("mask", mask_about, Need::optional)
            .out<Image>("image", filtered_about)
            .param(
                "sigma-space", &BilateralFilterImage::sigma_space,
                {.unit = "px", .min = 0.1, .max = 32, .about = "deviation of the spatial Gaussian"})
            .param("sigma-color", &BilateralFilterImage::sigma_color,
                   {.min = 1e-6,
                    .max = 1e6,
                    .about = "deviation of the colour Gaussian, in the picture's own values; of no "
                             "effect with 'variance'"})
            .param("sigma-noise", &BilateralFilterImage::sigma_noise,
                   {.min = 0.01,
                    .max = 100,
                    .about = "the same in deviations of the noise, with 'variance'"});
    }

    int radius() const { return int(std::ceil(3 * sigma_space)); }

    Cost cost(const Shapes& in) const {
        return similarity_cost(in, double((2 * radius() + 1) * (2 * radius() + 1)), 0);
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Guides guides = guides_of(in);
        kernel::Similarity by = similarity_of(guides, radius(), 0, ctx);
        by.taps = window(radius(), sigma_space);
        by.apart = false;
        by.color.subtract = 0;
        by.color.e = guides.variance ? 1e-20f : 2 * sigma_color * sigma_color;
        by.color.k2 = 2 * sigma_noise * sigma_noise;
        out.set("image", picture_of(means(by, ctx), guides, by, ctx));
    }
};

WEFT_NODE(BilateralFilterImage, "bilateral-filter-image", 1);

}  // namespace
}  // namespace weft
