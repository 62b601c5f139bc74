// a-trous: an edge-avoiding wavelet: a B-spline of 5 x 5 taps, run over and over with holes of 1,
// 2, 4 ... pixels between its taps, each tap weighted by likeness of features and colour. Wide for
// little work.
// Source: Dammertz, Sewtz, Hanika and Lensch 2010. Departures: feature noise is taken off; where
// the colour's variance is known it is followed through the passes (Schied et al. 2017, Sec. 4.2),
// so that colours are compared by the noise that is left.
#include <cmath>

#include "filters/guides.h"

namespace weft {
namespace {

struct ATrous : LayerChoice {
    int passes = 5;
    float sigma_color = 0.5f, k_color = 2, tighten = 0.5f;

    static void declare(Ports<ATrous>& node) {
        node.about(
                "edge-avoiding wavelet: passes of a 5 x 5 B-spline with holes of 1, 2, 4 ... "
                "pixels, weighted by likeness of features and of colour")
            .in<Image>("image", "scene-linear; all channels are filtered")
            .in<Image>("variance",
                       "of the noise of R G B; with it colours are compared by the noise left in "
                       "them after each pass, else by sigma-color",
                       Need::optional)
            .in<Image>("mask", mask_about, Need::optional)
            .out<Image>("image", filtered_about)
            .param(
                "passes", &ATrous::passes,
                {.min = 1, .max = 10, .about = "holes of 2^(pass - 1) pixels; 5 reach 62 pixels"})
            .param("sigma-color", &ATrous::sigma_color,
                   {.min = 1e-6,
                    .max = 1e6,
                    .about = "deviation of the colour Gaussian in the first pass, in the picture's "
                             "own values; of no effect with 'variance'"})
            .param("k-color", &ATrous::k_color,
                   {.min = 0.01,
                    .max = 100,
                    .about = "with 'variance': what passes as alike, in deviations of the noise"})
            .param("tighten", &ATrous::tighten,
                   {.min = 0.01,
                    .max = 1,
                    .about = "what sigma-color or k-color is multiplied by from pass to pass"});
        declare_layers(node);
    }

    Cost cost(const Shapes& in) const { return similarity_cost(in, 25.0 * passes, 0); }

    // 1 4 6 4 1, two ways, with holes.
    static std::vector<kernel::Tap> spline(int step) {
        constexpr float weights[5] = {1.0f / 16, 1.0f / 4, 3.0f / 8, 1.0f / 4, 1.0f / 16};
        std::vector<kernel::Tap> taps;
        for (int j = 0; j < 5; ++j)
            for (int i = 0; i < 5; ++i)
                taps.push_back({(i - 2) * step, (j - 2) * step, weights[i] * weights[j]});
        return taps;
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Guides guides = guides_of(in);
        // Planes are made once, with the margin of the widest pass.
        kernel::Similarity by = similarity_of(guides, 2 << (passes - 1), 0, ctx);
        add_features(guides, *this, by, ctx);
        by.apart = false;
        by.variances = by.color.variances;
        kernel::Planes made;
        for (int pass = 0; pass < passes; ++pass) {
            const int step = 1 << pass;
            const float tight = std::pow(tighten, float(pass));
            by.taps = spline(step);
            by.color.k2 = k_color * k_color * tight * tight;
            by.color.e = guides.variance ? 1e-20f : 2 * sigma_color * sigma_color * tight * tight;
            made = means(by, ctx, pass, passes, std::move(made));
            take_over(made, by, ctx);
            for (kernel::Term& feature : by.features)
                feature.slope_gain *= 4;  // taps are twice as far
        }
        out.set("image", picture_of(made, guides, by, ctx));
    }

    // What a pass made is what the next one filters; holes that it filled are none any more.
    static void take_over(const kernel::Planes& made, kernel::Similarity& by, Context& ctx) {
        ctx.parallel_rows(made.height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y) {
                for (int c = 0; c < made.count - 1; ++c)
                    std::copy_n(made.row(c, y), made.width, by.planes.row(c, y));
                for (int x = 0; x < made.width; ++x)
                    by.planes.row(by.known, y)[x] =
                        made.row(made.count - 1, y)[x] > 0 ? 1.0f : 0.0f;
            }
        });
    }
};

WEFT_NODE(ATrous, "a-trous", 1);

}  // namespace
}  // namespace weft
