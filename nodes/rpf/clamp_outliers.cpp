// clamp-outliers: what a pixel's own samples do not agree on after a filter's pass is taken for an
// outlier. Source: Sen and Darabi 2012, Sec. 4.4 (HDR clamp), in the forms that it was published
// in.
#include <algorithm>
#include <cmath>

#include "rpf/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

enum class Rule { none, mean, upper, joint };

struct ClampOutliers {
    Rule rule = Rule::joint;
    float deviations = 1;
    bool keep_energy = true;

    static void declare(Ports<ClampOutliers>& node) {
        node.about("brings a pixel's samples that differ most from their mean back to the others")
            .in<SampleColors>("colors", "filtered colours")
            .out<SampleColors>("colors", "the same, outliers less far")
            .choice("rule", &ClampOutliers::rule, {"none", "mean", "upper", "joint"},
                    {.about = "mean: a value too far becomes the mean, each colour for itself; "
                              "upper: one too bright becomes the brightest allowed, each "
                              "colour for itself; joint: a sample with any colour too far becomes "
                              "the mean in all"})
            .param("deviations", &ClampOutliers::deviations,
                   {.min = 0, .max = 100, .about = "of the pixel's samples that are allowed"})
            .param("keep-energy", &ClampOutliers::keep_energy,
                   {.about = "what a pixel loses is given back to all its samples, so that their "
                             "mean stays"});
    }

    void batch(const Inputs& in, Outputs& out) const {
        const SampleColors& from = in.get<SampleColors>("colors");
        SampleColors& to = out.get<SampleColors>("colors");
        to.own_pixels = from.own_pixels;
        to.own_offset = from.own_offset;
        to.sample = from.sample;
        to.effective = from.effective;
        to.rgb = from.rgb;
        if (rule == Rule::none) return;
        for (size_t p = 0; p < to.own_pixels.size(); ++p)
            clamp(&to.rgb[0] + 3 * to.own_offset[p], to.own_offset[p + 1] - to.own_offset[p]);
    }

  private:
    void clamp(float* rgb, size_t n) const {
        if (n < 2) return;
        float mean[3], far[3], after[3] = {};
        for (size_t c = 0; c < 3; ++c) {
            float sum = 0, squares = 0;
            for (size_t i = 0; i < n; ++i) sum += rgb[3 * i + c];
            mean[c] = sum / float(n);
            for (size_t i = 0; i < n; ++i)
                squares += (rgb[3 * i + c] - mean[c]) * (rgb[3 * i + c] - mean[c]);
            far[c] = deviations * std::sqrt(squares / float(n - 1));
        }
        for (size_t i = 0; i < n; ++i) {
            float* color = rgb + 3 * i;
            bool outside = false;
            for (size_t c = 0; c < 3; ++c) {
                const float off = color[c] - mean[c];
                outside = outside || std::abs(off) > far[c];
                if (rule == Rule::mean && std::abs(off) > far[c]) color[c] = mean[c];
                if (rule == Rule::upper) color[c] = std::min(color[c], mean[c] + far[c]);
            }
            if (rule == Rule::joint && outside) std::copy_n(mean, 3, color);
            for (size_t c = 0; c < 3; ++c) after[c] += color[c] / float(n);
        }
        if (!keep_energy) return;
        for (size_t i = 0; i < n; ++i)
            for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] += mean[c] - after[c];
    }
};

WEFT_NODE(ClampOutliers, "clamp-outliers", 1)

}  // namespace
}  // namespace weft
