// constant-weights: the same weights everywhere, in place of dependency-estimate: (alpha, beta) =
// (0, 0) blurs, (1, 0) is a bilateral filter of colours, (0, 1) a cross-bilateral filter of
// features, (1, 1) both. Source: Sen and Darabi 2012, Fig. 8 (the ablation).
#include "rpf/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct ConstantWeights {
    float alpha = 1, beta = 1, w_random = 0;

    static void declare(Ports<ConstantWeights>& node) {
        node.about("one weight for all colours and one for all features, whatever they depend on")
            .in<Neighbourhoods>("neighbourhoods", "normalised samples")
            .out<Weights>("weights", "the same for all blocks")
            .param("alpha", &ConstantWeights::alpha,
                   {.min = 0, .max = 1e6, .about = "of each colour"})
            .param("beta", &ConstantWeights::beta,
                   {.min = 0, .max = 1e6, .about = "of each feature"})
            .param(
                "w-random", &ConstantWeights::w_random,
                {.min = 0,
                 .max = 1,
                 .about =
                     "W_c^r: how much of the colour is taken for noise, which widens the filter"});
    }
    void batch(const Inputs& in, Outputs& out) const {
        const Neighbourhoods& n = in.get<Neighbourhoods>("neighbourhoods");
        Weights& w = out.get<Weights>("weights");
        w.of_row.assign(n.rows(), 0.0f);
        for (size_t k = 0; k < n.vectors->components.size(); ++k)
            if (n.vectors->components[k].role == Role::feature) w.of_row[k] = beta;
        for (size_t c = 0; c < 3; ++c) w.of_row[n.color_row(c)] = alpha;
        w.w_random = w_random;
        w.w_color = {w_random, w_random, w_random};
    }
};

WEFT_NODE(ConstantWeights, "constant-weights", 1)

}  // namespace
}  // namespace weft
