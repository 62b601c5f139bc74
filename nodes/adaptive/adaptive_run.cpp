#include "adaptive/adaptive_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "adaptive/scaled_space.h"
#include "samples/random.h"

namespace weft::adaptive {
namespace {

TreeSettings tree_settings(const SamplerFunction& sampler, const AdaptiveSettings& settings) {
    if (sampler.dimensions() < 2 || sampler.dimensions() > most_axes)
        throw Error(fmt::format("the sampler has {} axes; expected x, y and up to {} others",
                                sampler.dimensions(), most_axes - 2));
    TreeSettings made{.extent = {float(sampler.width), float(sampler.height)},
                      .capacity = size_t(settings.capacity),
                      .candidates = settings.candidates,
                      .reach = settings.reach,
                      .round = settings.round,
                      .contrast = settings.contrast,
                      .seed = settings.seed,
                      .alpha = settings.alpha,
                      .bits = settings.bits,
                      .extra_bits = settings.extra_bits};
    for (size_t d = 2; d < sampler.dimensions(); ++d)
        made.extent.push_back(settings.scale > 0          ? float(settings.scale)
                              : sampler.axes[d].scale > 0 ? sampler.axes[d].scale
                                                          : 0);
    if (!(settings.scale > 0)) shorten_axes(made.extent, settings.budget);
    return made;
}

double initial_of(const AdaptiveSettings& settings) {
    if (settings.initial > 0) return settings.initial;
    return settings.alpha > 0 ? 1 : 0.5 * settings.budget;
}

}  // namespace

AdaptiveRun::AdaptiveRun(const SamplerFunction& sampler, const AdaptiveSettings& settings)
    : sampler_(sampler),
      settings_(tree_settings(sampler, settings)),
      budget_(size_t(std::llround(settings.budget * double(sampler.pixels())))),
      tree_(settings_, size_t(initial_of(settings) * double(sampler.pixels())), budget_) {
    const size_t first = tree_.leaves() * settings_.capacity;
    if (first > budget_)
        throw Error(fmt::format(
            "a budget of {} samples does not fill the first {} boxes with {} each; raise budget to "
            "{:.3g}, or lower initial or capacity",
            budget_, tree_.leaves(), settings_.capacity, double(first) / double(sampler.pixels())));
}

std::vector<std::span<const float>> AdaptiveRun::request() {
    std::vector<std::span<const float>> places;
    if (done_ || tree_.samples() >= budget_ || tree_.request(budget_ - tree_.samples()) == 0)
        return places;
    for (size_t d = 0; d < tree_.dimensions(); ++d) places.push_back(tree_.places(d));
    return places;
}

void AdaptiveRun::insert(const Evaluated& values) {
    tree_.insert(values.rgb);
    features_.insert(features_.end(), values.features.begin(), values.features.end());
    broken_ += values.broken;
    const double largest = tree_.largest_error();
    if (largest_first_ == 0) largest_first_ = largest, left_first_ = tree_.total_error();
    done_ = largest < 1e-4 * largest_first_;
}

void AdaptiveRun::sample(double seconds, Context& ctx) {
    const auto start = std::chrono::steady_clock::now();
    const auto late = [&] {
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
        return seconds > 0 && spent.count() > seconds;
    };
    for (auto places = request(); !places.empty(); places = request()) {
        ctx.check_cancelled();
        insert(evaluate(sampler_, places, 0, ctx));
        // In whole per cent: units are kept for as long as the process runs.
        ctx.progress(double(tree_.samples()), double(budget_),
                     fmt::format("samples, {:.0f} % of the error left",
                                 100 * tree_.total_error() / left_first_));
        if (late()) break;
    }
}

void AdaptiveRun::judge(Context& ctx) const {
    judge_broken(broken_, tree_.samples(), ctx);
}

double AdaptiveRun::look_for_hidden_noise(Context& ctx) const {
    std::vector<std::vector<float>> places(tree_.dimensions());
    for (size_t i = 0; i < tree_.samples(); i += 100)
        for (size_t d = 0; d < tree_.dimensions(); ++d)
            places[d].push_back(below_one(tree_.at(d, i) / settings_.extent[d]));
    const std::vector<std::span<const float>> views(places.begin(), places.end());
    const Evaluated one = evaluate(sampler_, views, 0, ctx),
                    other = evaluate(sampler_, views, 1, ctx);
    double hidden = 0;
    for (size_t k = 0; k < one.rgb.size(); ++k)
        hidden += std::abs(double(one.rgb[k]) - double(other.rgb[k])) /
                  (std::sqrt(2.0) * double(one.rgb.size()));
    double within = 0, n = 0;
    for (size_t l = 0; l < tree_.leaves(); ++l) {
        const Tree::Leaf& leaf = tree_.leaf(l);
        for (size_t c = 0; c < 3; ++c) {
            double mean = 0;
            for (const std::uint32_t s : leaf.samples)
                mean += double(tree_.rgb()[3 * size_t(s) + c]) / double(leaf.samples.size());
            for (const std::uint32_t s : leaf.samples)
                within += std::abs(double(tree_.rgb()[3 * size_t(s) + c]) - mean), ++n;
        }
    }
    if (!(n > 0 && hidden > 0.2 * within / n)) return 0;
    const double part = std::min(1.0, hidden / (within / n));
    ctx.warn(fmt::format(
        "{:.0f} % of what samples of a box differ by no axis explains: boxes get samples "
        "that do not help them; make the axes explicit that are random, "
        "or sample evenly (uniform-samples)",
        100 * part));
    return part;
}

void AdaptiveRun::hand_out(Outputs& out, double hidden_noise) const {
    const size_t axes = tree_.dimensions(), n = tree_.samples();
    double pixel = 1;  // volume above one
    for (size_t d = 2; d < axes; ++d) pixel *= double(settings_.extent[d]);
    std::vector<float> weight(n);
    for (size_t l = 0; l < tree_.leaves(); ++l)
        for (const std::uint32_t s : tree_.leaf(l).samples)
            weight[s] =
                float(tree_.volume(tree_.leaf(l)) / (pixel * double(tree_.leaf(l).samples.size())));
    std::vector<std::vector<float>> points(axes);
    for (size_t d = 0; d < axes; ++d)
        for (size_t i = 0; i < n; ++i)
            points[d].push_back(std::min(tree_.at(d, i) / settings_.extent[d], 0x1.fffffep-1f));
    std::vector<std::uint32_t> order;
    const std::vector<std::span<const float>> views(points.begin(), points.end());
    const Evaluated values{{tree_.rgb().begin(), tree_.rgb().end()}, features_, 0};
    Samples samples = samples_of(sampler_, views, values, weight, order);
    if (hidden_noise > 0) samples.meta.set("hidden_noise", hidden_noise);
    std::vector<std::uint32_t> place(n);
    for (size_t i = 0; i < n; ++i) place[order[i]] = std::uint32_t(i);
    if (out.wanted("samples")) out.set("samples", std::move(samples));
    if (out.wanted("leaves")) out.set("leaves", leaves(place));
}

LeafTree AdaptiveRun::leaves(std::span<const std::uint32_t> place) const {
    const size_t axes = tree_.dimensions();
    LeafTree leaves;
    leaves.width = sampler_.width;
    leaves.height = sampler_.height;
    leaves.extent = settings_.extent;
    for (const SamplerAxis& axis : sampler_.axes) leaves.axes.push_back(axis.name);
    leaves.first.push_back(0);
    for (size_t l = 0; l < tree_.leaves(); ++l) {
        const Tree::Leaf& leaf = tree_.leaf(l);
        for (size_t d = 0; d < axes; ++d)
            leaves.lo.push_back(leaf.lo[d]), leaves.hi.push_back(leaf.hi[d]);
        double mean[3] = {};
        for (const std::uint32_t s : leaf.samples) {
            leaves.samples.push_back(place[s]);
            for (size_t c = 0; c < 3; ++c) mean[c] += double(tree_.rgb()[3 * size_t(s) + c]);
        }
        for (const double m : mean)
            leaves.mean.push_back(leaf.samples.empty() ? 0.0f
                                                       : float(m / double(leaf.samples.size())));
        leaves.first.push_back(std::uint32_t(leaves.samples.size()));
        leaves.error.push_back(float(tree_.errors()[l]));
    }
    return leaves;
}

void sample_adaptively(const SamplerFunction& sampler, const AdaptiveSettings& settings,
                       Outputs& out, Context& ctx) {
    AdaptiveRun run(sampler, settings);
    run.sample(settings.seconds, ctx);
    run.judge(ctx);
    run.hand_out(out, run.look_for_hidden_noise(ctx));
}

}  // namespace weft::adaptive
