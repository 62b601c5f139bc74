// non-local-means: each pixel becomes the mean of the pixels around it whose surroundings look like
// its own, as far as the noise lets one tell.
// Source: Buades, Coll and Morel 2005; the distance with known variances Rousselle, Knaus and
// Zwicker 2012, Sec. 4 (filters/similarity.h).
#include "filters/guides.h"

namespace weft {
namespace {

struct NonLocalMeans {
    int radius = 7, patch = 3;
    float k = 0.45f, epsilon = 1e-10f;

    static void declare(Ports<NonLocalMeans>& node) {
        node.about(
                "means of pixels whose surroundings are alike, by the variance of their noise: "
                "weight exp(-max(0, d^2)), d^2 the mean over a patch of ((a-b)^2 - (va + min(va, "
                "vb))) / (epsilon + k^2 (va + vb))")
            .in<Image>("image", "scene-linear; all channels are filtered, R G B compared")
            .in<Image>(
                "variance",
                "of the noise of these values, channels alike: 'color-variance' of "
                "'pixel-features'; without it there is no noise, and epsilon alone says what "
                "passes",
                Need::optional)
            .in<Image>("mask", mask_about, Need::optional)
            .out<Image>("image", filtered_about)
            .param(
                "radius", &NonLocalMeans::radius,
                {.unit = "px", .min = 0, .max = 64, .about = "of the window of pixels looked at"})
            .param("patch", &NonLocalMeans::patch,
                   {.unit = "px", .min = 0, .max = 16, .about = "radius of what is compared"})
            .param("k", &NonLocalMeans::k,
                   {.min = 0.01,
                    .max = 100,
                    .about = "what passes as alike, in deviations of the noise"})
            .param("epsilon", &NonLocalMeans::epsilon,
                   {.min = 1e-20,
                    .max = 1e6,
                    .about = "squared difference that passes without noise"});
    }

    Cost cost(const Shapes& in) const {
        return similarity_cost(in, double((2 * radius + 1) * (2 * radius + 1)), patch);
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Guides guides = guides_of(in);
        kernel::Similarity by = similarity_of(guides, radius, patch, ctx);
        by.taps = window(radius);
        by.color.e = epsilon;
        by.color.k2 = k * k;
        out.set("image", picture_of(means(by, ctx), guides, by, ctx));
    }
};

WEFT_NODE(NonLocalMeans, "non-local-means", 1);

}  // namespace
}  // namespace weft
