// dependency-estimate: how far each colour and feature of a neighbourhood depends on random
// parameters and how far on position, and what follows for the filter: noise is not to be told
// apart from noise. Source: Sen and Darabi 2012, Sec. 3.2 and 4.2 (D, W, alpha, beta), by mutual
// information.  Departures, all optional: bias taken off; one dependence a set of channels; one
// weight a vector; a prior.
#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "rpf/kernels.h"
#include "rpf/mutual_information.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace rpf;

enum class Combine { sum, mean, largest };
enum class ColorNoise { mean_of_ratios, ratio_of_sums };

struct DependencyEstimate {
    int bins = 5, iteration = 0;
    Binning binning = Binning::centered;
    Correction correction = Correction::asymptotic;
    Combine combine = Combine::sum;
    ColorNoise color_noise = ColorNoise::ratio_of_sums;
    std::vector<std::string> random, features, gains;
    bool position = true, per_color = true, per_vector = false, color_share = true;
    float alpha_gain = 1, alpha_gain_step = 0, beta_gain = 1, beta_gain_step = 0, prior = 0;

    static void declare(Ports<DependencyEstimate>& node) {
        node.about(
                "weights of features and colours from how far they depend on random parameters, by "
                "mutual information")
            .in<Neighbourhoods>("neighbourhoods", "normalised samples")
            .out<Weights>("weights",
                          "alpha of each colour, beta of each feature, and W_c^r, how much of the "
                          "colour is noise")
            .param("random", &DependencyEstimate::random,
                   {.about = "random parameters that count, as uv, t; empty: all of the vectors"})
            .param("features", &DependencyEstimate::features,
                   {.about = "features that count, as normal; empty: all of the vectors"})
            .param("position", &DependencyEstimate::position,
                   {.about = "weigh dependence on random parameters against that on position"})
            .param("bins", &DependencyEstimate::bins,
                   {.min = 2,
                    .max = int(most_bins),
                    .about = "of a histogram, where binning does not say"})
            .choice("binning", &DependencyEstimate::binning, {"centered", "spanned", "rank"},
                    {.about = "centered: one deviation wide around the mean, the outer bins open; "
                              "spanned: one deviation wide, at most 10; rank: equal "
                              "numbers of samples"})
            .choice(
                "correction", &DependencyEstimate::correction,
                {"none", "miller-madow", "asymptotic", "shuffle"},
                {.about =
                     "what is taken off, as independent channels seem dependent in few samples"})
            .choice("combine", &DependencyEstimate::combine, {"sum", "mean", "largest"},
                    {.about = "dependence on a set of channels from that on each"})
            .choice("color-noise", &DependencyEstimate::color_noise,
                    {"mean-of-ratios", "ratio-of-sums"}, {.about = "W_c^r from the three colours"})
            .param("per-color", &DependencyEstimate::per_color,
                   {.about = "an alpha a colour, or one for all three"})
            .param("per-vector", &DependencyEstimate::per_vector,
                   {.about = "a beta a feature channel (its components' mean), or one a component"})
            .param("prior", &DependencyEstimate::prior,
                   {.unit = "nats x samples",
                    .min = 0,
                    .max = 1e4,
                    .about = "dependence on position that is taken for granted, over the number of "
                             "samples"})
            .param("alpha-gain", &DependencyEstimate::alpha_gain,
                   {.min = 0, .max = 100, .about = "alpha = 1 - gain W"})
            .param("alpha-gain-step", &DependencyEstimate::alpha_gain_step,
                   {.min = -10, .max = 10, .about = "added to it each iteration"})
            .param("beta-gain", &DependencyEstimate::beta_gain,
                   {.min = 0, .max = 100, .about = "beta = W_c^f (1 - gain W_f)"})
            .param("beta-gain-step", &DependencyEstimate::beta_gain_step,
                   {.min = -10, .max = 10, .about = "added to it each iteration"})
            .param("color-share", &DependencyEstimate::color_share,
                   {.about = "beta = W_c^f (1 - gain W_f), or without W_c^f"})
            .param("gains", &DependencyEstimate::gains,
                   {.about = "further factors of beta, as albedo=25, normal=10"})
            .param("iteration", &DependencyEstimate::iteration,
                   {.min = 0, .max = 100, .about = "which pass this is, from 0"});
    }

    struct Scratch {
        std::vector<size_t> random, position, features;  // rows
        std::vector<float> gain;                         // of each row
        std::vector<NumberRow> rows;                     // random, position, colours, features
        BinnedRows binned;
        MutualInformation information;
        std::vector<double> by_parameter, by_feature;  // I of colours and features with random and
                                                       // position; of colours with features
        std::vector<double> to_color;                  // of each feature: I with the colours
        const SampleVectors* of = nullptr;
    };

    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Neighbourhoods& n = in.get<Neighbourhoods>("neighbourhoods");
        Weights& w = out.get<Weights>("weights");
        choose_rows(*n.vectors, scratch);
        w.of_row.assign(n.rows(), 0.0f);
        w.w_color = {0, 0, 0};
        w.w_random = 0;
        if (n.samples() == 0) return;
        estimate(n, scratch);

        const size_t parameters = scratch.random.size() + scratch.position.size(),
                     used = scratch.features.size();
        const auto dependence = [&](size_t which, size_t begin, size_t end) {
            double sum = 0, most = 0;
            for (size_t k = begin; k < end; ++k) {
                const double i = scratch.by_parameter[which * parameters + k];
                sum += i;
                most = std::max(most, i);
            }
            return combine == Combine::sum       ? sum
                   : combine == Combine::largest ? most
                                                 : sum / std::max(1.0, double(end - begin));
        };
        // Of a colour (0 to 2) or a feature (from 3 on).
        const auto on_random = [&](size_t which) {
            return dependence(which, 0, scratch.random.size());
        };
        const auto on_position = [&](size_t which) {
            return dependence(which, scratch.random.size(), parameters);
        };
        const double granted = double(prior) / double(n.samples());
        const auto share = [&](double by_random, double by_position) {
            return float(by_random / (by_random + by_position + granted + 1e-10));
        };

        double all_random = 0, all_position = 0, all_features = 0;
        std::vector<double>& to_color = scratch.to_color;
        to_color.assign(used, 0.0);
        for (size_t c = 0; c < 3; ++c) {
            const double by_random = on_random(c), by_position = on_position(c);
            w.w_color[c] = share(by_random, by_position);
            all_random += by_random;
            all_position += by_position;
            for (size_t k = 0; k < used; ++k) {
                const double i = scratch.by_feature[c * used + k];
                to_color[k] += i;
                all_features += i;
            }
        }
        w.w_random = color_noise == ColorNoise::ratio_of_sums
                         ? share(all_random, all_position)
                         : (w.w_color[0] + w.w_color[1] + w.w_color[2]) / 3;
        const float alpha_by = alpha_gain + alpha_gain_step * float(iteration),
                    beta_by = beta_gain + beta_gain_step * float(iteration);
        for (size_t c = 0; c < 3; ++c)
            w.of_row[n.color_row(c)] =
                std::max(0.0f, 1 - alpha_by * (per_color ? w.w_color[c] : w.w_random));
        const double all = all_random + all_position + all_features + 1e-10;
        for (size_t k = 0; k < used; ++k) {
            const size_t row = scratch.features[k];
            const float noise = share(on_random(3 + k), on_position(3 + k));
            w.of_row[row] = (color_share ? float(to_color[k] / all) : 1.0f) *
                            std::max(0.0f, 1 - beta_by * noise) * scratch.gain[row];
        }
        if (per_vector) share_betas(*n.vectors, w.of_row);
    }

  private:
    void choose_rows(const SampleVectors& v, Scratch& scratch) const {
        if (scratch.of == &v) return;
        scratch.of = &v;
        scratch.information = MutualInformation(correction);
        scratch.random = rows_of(v, Role::random, random);
        scratch.features = rows_of(v, Role::feature, features);
        scratch.position.clear();
        if (position) scratch.position = rows_of(v, Role::position, {});
        scratch.gain.assign(v.stride(), 1.0f);
        for (const std::string& text : gains) {
            const size_t equals = text.find('=');
            float gain = 0;
            const char* end = text.data() + text.size();
            if (equals == std::string::npos ||
                std::from_chars(text.data() + equals + 1, end, gain).ptr != end || !(gain >= 0))
                throw Error(
                    fmt::format("gains has '{}'; expected a channel's name, '=' and a number of at "
                                "least 0, as albedo=25",
                                text));
            for (const size_t row : rows_of(v, Role::feature, {text.substr(0, equals)}))
                scratch.gain[row] = gain;
        }
    }
    // Names of channels that the vectors do not have (never changing ones are left out) have no
    // rows.
    static std::vector<size_t> rows_of(const SampleVectors& v, Role role,
                                       const std::vector<std::string>& names) {
        std::vector<size_t> rows;
        for (size_t k = 0; k < v.components.size(); ++k) {
            const std::string& name = v.channels[size_t(v.components[k].channel)];
            if (v.components[k].role == role &&
                (names.empty() || std::find(names.begin(), names.end(), name) != names.end()))
                rows.push_back(k);
        }
        return rows;
    }
    void estimate(const Neighbourhoods& n, Scratch& scratch) const {
        scratch.rows.clear();
        const auto add = [&](size_t row) {
            scratch.rows.push_back(
                {n.row(row), n.low[row], n.high[row], n.mean[row], n.scale[row]});
        };
        for (const size_t row : scratch.random) add(row);
        for (const size_t row : scratch.position) add(row);
        const size_t colors = scratch.rows.size(), rest = colors + 3;
        for (size_t c = 0; c < 3; ++c) add(n.color_row(c));
        for (const size_t row : scratch.features) add(row);
        const size_t all = scratch.rows.size();
        sort_rows(scratch.rows, n.samples(), binning, size_t(bins), scratch.binned);
        scratch.information(scratch.binned, {colors, all}, {0, colors}, scratch.by_parameter);
        scratch.information(scratch.binned, {colors, rest}, {rest, all}, scratch.by_feature);
    }
    static void share_betas(const SampleVectors& v, std::vector<float>& of_row) {
        for (size_t c = 0; c < v.channels.size(); ++c) {
            const auto [begin, end] = v.of_channel(c);
            float sum = 0;
            for (size_t k = begin; k < end; ++k) sum += of_row[k];
            for (size_t k = begin; k < end; ++k) of_row[k] = sum / float(end - begin);
        }
    }
};

WEFT_NODE(DependencyEstimate, "dependency-estimate", 2)

}  // namespace
}  // namespace weft
