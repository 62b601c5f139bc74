// bilateral-filter: the colour of each of a block's own samples becomes the mean over its
// neighbourhood, weighted by how like the samples' features and colours are:
//     w = exp(-(1 - W)^2 / (2 sigma^2) sum alpha dc^2) exp(-(1 - W)^2 / (2 sigma^2) sum beta df^2)
// The nearness on the screen is in how neighbours were drawn.  Likeness is always that of the
// colours as rendered. Source: Sen and Darabi 2012, Sec. 4.3.
#include <cmath>

#include "rpf/kernels.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace rpf;

struct BilateralFilter {
    float variance = 0.02f, gain_step = 0, cutoff = 6;
    bool per_spp = true;
    int iteration = 0;

    static void declare(Ports<BilateralFilter>& node) {
        node.about(
                "filters each sample's colour over its neighbourhood by likeness of features and "
                "colours")
            .in<Neighbourhoods>("neighbourhoods", "normalised samples")
            .in<Weights>("weights", "what each feature and colour counts")
            .in<Samples>("colors",
                         "the colours to average, as a pass before left them; the vectors' own "
                         "where there was none",
                         Need::optional)
            .out<SampleColors>("colors", "filtered colours of the block's own samples")
            .param("variance", &BilateralFilter::variance,
                   {.min = 1e-6,
                    .max = 1e6,
                    .about = "sigma^2, in variances of the neighbourhood, at 8 samples a pixel"})
            .param("per-spp", &BilateralFilter::per_spp,
                   {.about = "sigma^2 shrinks with the samples a pixel has"})
            .param("gain-step", &BilateralFilter::gain_step,
                   {.min = -10, .max = 10, .about = "exponents times 1 + step x iteration"})
            .param("cutoff", &BilateralFilter::cutoff,
                   {.min = 0.1, .max = 80, .about = "exponent from which on a weight is 0"})
            .param("iteration", &BilateralFilter::iteration,
                   {.min = 0, .max = 100, .about = "which pass this is, from 0"});
    }
    using Scratch = FilterScratch;

    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Neighbourhoods& n = in.get<Neighbourhoods>("neighbourhoods");
        const Weights& weights = in.get<Weights>("weights");
        const Samples& samples = n.vectors->samples;
        const Samples& colors = in.get_or<Samples>("colors", samples);
        SampleColors& to = out.get<SampleColors>("colors");
        to.take_own(n, colors);
        const double spp = std::max(samples.mean_spp(), 1e-3);
        const float sigma2 = variance * (per_spp ? float(8 / spp) : 1.0f),
                    signal = 1 - weights.w_random;
        const Likeness likeness{signal * signal * (1 + gain_step * float(iteration)) / (2 * sigma2),
                                cutoff};
        WEFT_PICK(filter)(n, weights, colors.rgb().data(), likeness, scratch, to);
    }
};

WEFT_NODE(BilateralFilter, "bilateral-filter", 3)

}  // namespace
}  // namespace weft
