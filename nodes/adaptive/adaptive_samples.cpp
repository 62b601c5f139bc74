// adaptive-samples: samples where the picture, over all its axes, is not yet known:
// multidimensional adaptive sampling. Source: Hachisuka et al. 2008; rounds after Meister and
// Hachisuka 2022. See adaptive_tree.h. Departure: the scale of an axis is how far the picture moves
// over it, as the sampler says, not a user's guess.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "adaptive/adaptive_tree.h"
#include "adaptive/leaf_tree.h"
#include "adaptive/sampled_points.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

struct AdaptiveSamples {
    double budget = 8, initial = 1, round = 1.0 / 16;
    int capacity = 4, candidates = 4;
    Contrast contrast = Contrast::relative;
    double scale = 0;
    std::uint64_t seed = 1;

    static void declare(Ports<AdaptiveSamples>& node) {
        node.about(
                "samples a renderer where its picture varies over film, lens, time and light "
                "together")
            .in<SamplerFunction>("sampler", "what to sample; two to eight axes")
            .out<Samples>("samples",
                          "xy, uv and t as it has them, its other axes, rgb, weight: as many a "
                          "pixel as it took")
            .out<LeafTree>("leaves", "the boxes that the domain was cut into")
            .param("budget", &AdaptiveSamples::budget,
                   {.unit = "samples a pixel", .min = 0.01, .max = 65536, .about = "on average"})
            .param(
                "initial", &AdaptiveSamples::initial,
                {.unit = "samples a pixel",
                 .min = 0.01,
                 .max = 65536,
                 .about =
                     "of the budget, spread evenly first; what is missed then is not looked for"})
            .param("round", &AdaptiveSamples::round,
                   {.min = 0, .max = 1, .about = "part of the boxes that get a sample at a time"})
            .param("capacity", &AdaptiveSamples::capacity,
                   {.unit = "samples", .min = 2, .max = 64, .about = "in a box before it is cut"})
            .param(
                "candidates", &AdaptiveSamples::candidates,
                {.min = 1,
                 .max = 64,
                 .about = "places tried for a sample, of which the farthest from others is taken"})
            .choice("contrast", &AdaptiveSamples::contrast, {"relative", "absolute", "sqrt"},
                    {.about = "what difference counts against: its box's mean, nothing, or that "
                              "mean's root"})
            .param("scale", &AdaptiveSamples::scale,
                   {.unit = "px",
                    .min = 0,
                    .max = 65536,
                    .about = "of every axis but x and y: how far the picture moves over it; 0: as "
                             "the sampler says, else 16"})
            .param("seed", &AdaptiveSamples::seed,
                   {.min = 0, .about = "another number, other points"});
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const SamplerFunction& sampler = in.get<SamplerFunction>("sampler");
        if (sampler.dimensions() < 2 || sampler.dimensions() > most_axes)
            ctx.fail(fmt::format("the sampler has {} axes; expected x, y and up to {} others",
                                 sampler.dimensions(), most_axes - 2));
        TreeSettings settings{.extent = extent_of(sampler),
                              .capacity = size_t(capacity),
                              .candidates = candidates,
                              .round = round,
                              .contrast = contrast,
                              .seed = seed};
        const auto all = size_t(std::llround(budget * double(sampler.pixels())));
        Tree tree(settings, size_t(initial * double(sampler.pixels())));
        const size_t first = tree.leaves() * settings.capacity;
        if (first > all)
            ctx.fail(fmt::format(
                "a budget of {} samples does not fill the first {} boxes with {} each; raise "
                "budget to {:.3g}, or lower initial or capacity",
                all, tree.leaves(), capacity, double(first) / double(sampler.pixels())));

        size_t broken = 0;
        double largest_first = 0, left_first = 0;
        while (tree.samples() < all) {
            const size_t n = tree.request(all - tree.samples());
            if (n == 0) break;
            ctx.check_cancelled();
            std::vector<std::span<const float>> places;
            for (size_t d = 0; d < tree.dimensions(); ++d) places.push_back(tree.places(d));
            tree.insert(evaluate(sampler, places, 0, broken, ctx));
            const double largest = tree.largest_error(), left = tree.total_error();
            if (largest_first == 0) largest_first = largest, left_first = left;
            if (largest < 1e-4 * largest_first) break;
            // In whole per cent: units are kept for as long as the process runs.
            ctx.progress(
                double(tree.samples()), double(all),
                fmt::format("samples, {:.0f} % of the error left", 100 * left / left_first));
        }
        judge_broken(broken, tree.samples(), ctx);
        look_for_hidden_noise(sampler, settings.extent, tree, ctx);
        hand_out(sampler, settings, tree, out);
    }

  private:
    std::vector<float> extent_of(const SamplerFunction& sampler) const {
        std::vector<float> extent{float(sampler.width), float(sampler.height)};
        for (size_t d = 2; d < sampler.dimensions(); ++d)
            extent.push_back(scale > 0                   ? float(scale)
                             : sampler.axes[d].scale > 0 ? sampler.axes[d].scale
                                                         : 16);
        return extent;
    }
    // Samples that differ although they are of the same point differ by what no axis explains:
    // every box looks as if it needed more, and none is helped by it. One in a hundred is asked for
    // again.
    static void look_for_hidden_noise(const SamplerFunction& sampler, std::span<const float> extent,
                                      const Tree& tree, Context& ctx) {
        std::vector<std::vector<float>> places(tree.dimensions());
        for (size_t i = 0; i < tree.samples(); i += 100) {
            for (size_t d = 0; d < tree.dimensions(); ++d)
                places[d].push_back(tree.at(d)[i] / extent[d]);
        }
        size_t broken = 0;
        const std::vector<std::span<const float>> views(places.begin(), places.end());
        const std::vector<float> one = evaluate(sampler, views, 0, broken, ctx),
                                 other = evaluate(sampler, views, 1, broken, ctx);
        double hidden = 0;
        for (size_t k = 0; k < one.size(); ++k)
            hidden +=
                std::abs(double(one[k]) - double(other[k])) / (std::sqrt(2.0) * double(one.size()));
        double within = 0, n = 0;
        for (size_t l = 0; l < tree.leaves(); ++l) {
            const Tree::Leaf& leaf = tree.leaf(l);
            for (size_t c = 0; c < 3; ++c) {
                double mean = 0;
                for (const std::uint32_t s : leaf.samples)
                    mean += double(tree.rgb()[3 * size_t(s) + c]) / double(leaf.samples.size());
                for (const std::uint32_t s : leaf.samples)
                    within += std::abs(double(tree.rgb()[3 * size_t(s) + c]) - mean), ++n;
            }
        }
        if (n > 0 && hidden > 0.2 * within / n)
            ctx.warn(fmt::format(
                "{:.0f} % of what samples of a box differ by no axis explains: boxes get samples "
                "that do not help them; make the axes explicit that are random, "
                "or sample evenly (uniform-samples)",
                std::min(100.0, 100 * hidden / (within / n))));
    }
    static void hand_out(const SamplerFunction& sampler, const TreeSettings& settings,
                         const Tree& tree, Outputs& out) {
        const size_t axes = tree.dimensions(), n = tree.samples();
        double pixel = 1;  // volume above one
        for (size_t d = 2; d < axes; ++d) pixel *= double(settings.extent[d]);
        std::vector<float> weight(n);
        for (size_t l = 0; l < tree.leaves(); ++l)
            for (const std::uint32_t s : tree.leaf(l).samples)
                weight[s] = float(tree.volume(tree.leaf(l)) /
                                  (pixel * double(tree.leaf(l).samples.size())));
        std::vector<std::vector<float>> points(axes);
        for (size_t d = 0; d < axes; ++d)
            for (const float x : tree.at(d))
                points[d].push_back(std::min(x / settings.extent[d], 0x1.fffffep-1f));
        std::vector<std::uint32_t> order;
        const std::vector<std::span<const float>> views(points.begin(), points.end());
        Samples samples = samples_of(sampler, views, tree.rgb(), weight, order);
        std::vector<std::uint32_t> place(n);
        for (size_t i = 0; i < n; ++i) place[order[i]] = std::uint32_t(i);

        LeafTree leaves;
        leaves.width = sampler.width;
        leaves.height = sampler.height;
        leaves.extent = settings.extent;
        for (const SamplerAxis& axis : sampler.axes) leaves.axes.push_back(axis.name);
        leaves.first.push_back(0);
        for (size_t l = 0; l < tree.leaves(); ++l) {
            const Tree::Leaf& leaf = tree.leaf(l);
            for (size_t d = 0; d < axes; ++d)
                leaves.lo.push_back(leaf.lo[d]), leaves.hi.push_back(leaf.hi[d]);
            double mean[3] = {};
            for (const std::uint32_t s : leaf.samples) {
                leaves.samples.push_back(place[s]);
                for (size_t c = 0; c < 3; ++c) mean[c] += double(tree.rgb()[3 * size_t(s) + c]);
            }
            for (const double m : mean)
                leaves.mean.push_back(
                    leaf.samples.empty() ? 0.0f : float(m / double(leaf.samples.size())));
            leaves.first.push_back(std::uint32_t(leaves.samples.size()));
            leaves.error.push_back(float(leaf.error));
        }
        out.set("samples", std::move(samples));
        out.set("leaves", std::move(leaves));
    }
};

WEFT_NODE(AdaptiveSamples, "adaptive-samples", 1)

}  // namespace
}  // namespace weft
