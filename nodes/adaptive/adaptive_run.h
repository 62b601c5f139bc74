// One adaptive sampling: which points it asks for, round after round, and what it hands out. The
// same whether a node calls the sampler or somebody else answers the requests.
#pragma once
#include "adaptive/adaptive_tree.h"
#include "adaptive/leaf_tree.h"
#include "adaptive/sampled_points.h"
#include "runtime/node.h"

namespace weft::adaptive {

struct AdaptiveSettings {
    double budget = 8, round = 1.0 / 16;
    double initial = 0;  // 0: half the budget; by chance: one a pixel
    int capacity = 4, candidates = 4;
    Reach reach = Reach::leaf;
    Contrast contrast = Contrast::relative;
    double scale = 0;
    std::uint64_t seed = 1;
    double alpha = 0;                // by chance; 0: the leaves of largest error
    int bits = -1, extra_bits = -1;  // first cells are 2^bits along an axis; -1: by `initial`
    double seconds = 0;              // of sampling, after which no round is begun; 0: no limit

    // Parameters that all ways to sample adaptively have.
    template <class Node>
    static void declare_shared(Ports<Node>& node) {
        const auto of = []<class T>(T AdaptiveSettings::*field) {
            return static_cast<T Node::*>(field);
        };
        node.param("budget", of(&AdaptiveSettings::budget),
                   {.unit = "samples a pixel", .min = 0.01, .max = 65536, .about = "on average"})
            .param("capacity", of(&AdaptiveSettings::capacity),
                   {.unit = "samples", .min = 2, .max = 64, .about = "in a box before it is cut"})
            .param(
                "candidates", of(&AdaptiveSettings::candidates),
                {.min = 1,
                 .max = 64,
                 .about = "places tried for a sample, of which the farthest from others is taken"})
            .choice("reach", of(&AdaptiveSettings::reach), {"leaf", "neighbours"},
                    {.about = "whose samples those are: the box's, or also those of boxes that "
                              "share a face with it"})
            .choice("contrast", of(&AdaptiveSettings::contrast), {"relative", "absolute", "sqrt"},
                    {.about = "what difference counts against: its box's mean, nothing, or that "
                              "mean's root"})
            .param("scale", of(&AdaptiveSettings::scale),
                   {.unit = "px",
                    .min = 0,
                    .max = 65536,
                    .about = "of every axis but x and y: how far the picture moves over it; 0: as "
                             "the sampler says, else 16"})
            .param("seed", of(&AdaptiveSettings::seed),
                   {.min = 0, .about = "another number, other points"});
    }
    template <class Node>
    static void declare_rounds(Ports<Node>& node) {
        node.param("initial", static_cast<double Node::*>(&AdaptiveSettings::initial),
                   {.unit = "samples a pixel",
                    .min = 0,
                    .max = 65536,
                    .about = "of the budget, spread evenly first; what is missed then is not "
                             "looked for; 0: half of it"})
            .param("round", static_cast<double Node::*>(&AdaptiveSettings::round),
                   {.min = 0, .max = 1, .about = "part of the boxes that get a sample at a time"});
    }
};

class AdaptiveRun {
  public:
    // `sampler` must outlive this; only what it says of itself is looked at, unless sample() is
    // called. Throws Error where the budget does not fill the first boxes.
    AdaptiveRun(const SamplerFunction& sampler, const AdaptiveSettings& settings);

    // Points of the next round, axes x n in [0, 1]; none: it is done.
    std::vector<std::span<const float>> request();
    void insert(const Evaluated& values);
    // Round after round, to the end, or to the first that ends after `seconds`; 0: no limit.
    void sample(double seconds, Context& ctx);

    size_t samples() const { return tree_.samples(); }
    // Warns of points that had no radiance.
    void judge(Context& ctx) const;
    // Warns of noise that no axis explains: every box looks as if it needed more samples, and none
    // is helped by them. One point in a hundred is asked for again. The part of what samples of a
    // box differ by; 0 where it is small.
    double look_for_hidden_noise(Context& ctx) const;
    // `hidden_noise` goes into the samples' meta.
    void hand_out(Outputs& out, double hidden_noise = 0) const;

  private:
    LeafTree leaves(std::span<const std::uint32_t> place) const;

    const SamplerFunction& sampler_;
    TreeSettings settings_;
    size_t budget_;
    Tree tree_;
    std::vector<float> features_;
    size_t broken_ = 0;
    double largest_first_ = 0, left_first_ = 0;
    bool done_ = false;
};

// From the first point to `samples` and `leaves`, with all warnings.
void sample_adaptively(const SamplerFunction& sampler, const AdaptiveSettings& settings,
                       Outputs& out, Context& ctx);

}  // namespace weft::adaptive
