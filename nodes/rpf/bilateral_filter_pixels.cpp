// bilateral-filter-pixels: as bilateral-filter, but samples count by how like the pixels are that
// they come from: by means of colours and features, of whose differences what noise alone makes is
// taken off. Pixels that see the same through lens and shutter have like means although no two of
// their samples are alike; and what no feature shows, as a shadow's edge, the colours of a patch of
// pixels do, however noisy each sample is. Source: Sen and Darabi 2012, Sec. 4.3 (the filter,
// alpha, beta); Rousselle, Knaus and Zwicker 2012, 2013 (the distances).
#include <algorithm>
#include <cmath>

#include "rpf/kernels.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace rpf;

struct BilateralFilterPixels {
    int radius = 7;
    float sigma = 3, k_color = 0.5f, k_features = 2, slope = 4, least = 0.02f, surface_slope = 1;
    bool surfaces = false;

    static void declare(Ports<BilateralFilterPixels>& node) {
        node.about("filters each sample's colour over pixels that are alike, noise taken off")
            .in<Neighbourhoods>("neighbourhoods", "normalised samples")
            .in<Weights>("weights", "what each feature and colour counts")
            .in<Samples>("colors",
                         "the colours to average, as a pass before left them; the vectors' own "
                         "where there was none",
                         Need::optional)
            .out<SampleColors>("colors", "filtered colours of the block's own samples")
            .param("radius", &BilateralFilterPixels::radius,
                   {.unit = "px",
                    .min = 0,
                    .max = 15,
                    .about = "of the window: (2 radius + 1)^2 pixels"})
            .param(
                "sigma", &BilateralFilterPixels::sigma,
                {.unit = "px", .min = 0.1, .max = 64, .about = "deviation of the spatial Gaussian"})
            .param("k-color", &BilateralFilterPixels::k_color,
                   {.min = 0.01,
                    .max = 100,
                    .about = "what passes as alike, in deviations of the colours' noise"})
            .param("k-features", &BilateralFilterPixels::k_features,
                   {.min = 0, .max = 100, .about = "the same of features"})
            .param("slope", &BilateralFilterPixels::slope,
                   {.unit = "px",
                    .min = 0,
                    .max = 100,
                    .about = "how many pixels' worth of its own slope a feature may change by"})
            .param("least", &BilateralFilterPixels::least,
                   {.min = 0,
                    .max = 100,
                    .about = "what a feature may change by where it has no slope, as part of its "
                             "deviation over the picture"})
            .param("surfaces", &BilateralFilterPixels::surfaces,
                   {.about = "of a pixel that is alike only samples whose own features are like "
                             "the sample's: for samples without lens and motion "
                             "blur, whose surfaces are to stay apart"})
            .param("surface-slope", &BilateralFilterPixels::surface_slope,
                   {.unit = "px",
                    .min = 0.01,
                    .max = 100,
                    .about = "how many pixels' worth of its slope a feature may change by within a "
                             "surface"});
    }
    struct Scratch {
        PixelScratch pixels;
        AroundScratch around;
        std::vector<float> weights, factors;
    };

    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Neighbourhoods& n = in.get<Neighbourhoods>("neighbourhoods");
        const SampleVectors& v = *n.vectors;
        if (v.pixels.planes.values.empty())
            throw Error(
                "'bilateral-filter-pixels' needs what pixels' samples say together; set 'pixels' "
                "of 'build-vectors' to true");
        const Samples& colors = in.get_or<Samples>("colors", v.samples);
        SampleColors& to = out.get<SampleColors>("colors");
        to.take_own(n, colors);
        const PixelLikeness by{radius, sigma, k_color, k_features, slope, least};
        WEFT_PICK(weigh_pixels)
        (v, n.block, in.get<Weights>("weights"), by, scratch.pixels, scratch.weights);
        const float* rgb = colors.rgb().data();
        const bool means = !surfaces && rgb == v.samples.rgb().data();  // that pixels have
        const auto width = std::uint32_t(v.samples.width);
        for (size_t p = 0; p < n.own_pixels.size(); ++p) {
            const int x = int(n.own_pixels[p] % width), y = int(n.own_pixels[p] / width);
            const size_t begin = n.own_offset[p], end = n.own_offset[p + 1];
            if (begin == end) continue;
            const float* weights = &scratch.weights[p * by.size()];
            find_factors(v, x, y, scratch);
            const std::span own(&n.sample[begin], surfaces ? end - begin : 1);
            if (means) WEFT_PICK(average_pixels)
            (v, x, y, by, weights, &to.rgb[3 * begin], &to.effective[begin]);
            else WEFT_PICK(average_samples)(v, rgb, own, x, y, by, weights, scratch.factors,
                                            scratch.around, &to.rgb[3 * begin],
                                            &to.effective[begin]);
            for (size_t i = begin + 1; i < end && !surfaces; ++i) {
                std::copy_n(&to.rgb[3 * begin], 3, &to.rgb[3 * i]);
                to.effective[i] = to.effective[begin];
            }
        }
    }

  private:
    // Of each feature component what its differences are multiplied by; filled up to whole vectors.
    void find_factors(const SampleVectors& v, int x, int y, Scratch& scratch) const {
        const PixelStatistics& p = v.pixels;
        scratch.factors.assign((v.components.size() - p.first + 15) / 16 * 16, 0.0f);
        if (!surfaces) return;
        for (size_t g = 0; g < p.groups.size(); ++g) {
            const float pass = surface_slope * surface_slope *
                               std::max({1e-30f, least * least * p.groups[g].deviation2 / 16,
                                         p.planes.row(p.slope(g), y)[x]});
            for (size_t k = p.groups[g].begin; k < p.groups[g].end; ++k)
                scratch.factors[k - p.first] = std::sqrt(0.5f * scratch.pixels.beta[g] / pass);
        }
    }
};

WEFT_NODE(BilateralFilterPixels, "bilateral-filter-pixels", 1)

}  // namespace
}  // namespace weft
