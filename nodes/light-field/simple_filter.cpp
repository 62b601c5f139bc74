// gaussian-visible and nearest-visible: other filters of the surface seen, to put in filter-visible's place.
//   gaussian-visible   weight exp(-d^2 / 2 sigma^2), no end but the search's
//   nearest-visible    the nearest sample alone: nothing is blurred, everything is noisy
#include <algorithm>
#include <cmath>

#include "light-field/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

template <class Node>
void declare_filter(Ports<Node>& node, const char* about) {
    node.about(about)
        .template in<Candidates>("candidates", "the samples near each location")
        .template in<Surfaces>("surfaces", "their surfaces")
        .template in<Visibility>("visibility", "the surface seen")
        .template out<Colors>("colors", "radiance of each location that is decided");
}

// weight(d^2, least d^2 of the location's samples, its R over the hierarchy's).
template <class Weight>
void filter_each(const Inputs& in, Outputs& out, Weight&& weight) {
    const Candidates& c = in.get<Candidates>("candidates");
    const Surfaces& s = in.get<Surfaces>("surfaces");
    const Visibility& v = in.get<Visibility>("visibility");
    Colors& colors = out.get<Colors>("colors");
    const Hierarchy& h = *c.hierarchy;
    h.require_colors();
    colors.color_space = &h.color_space;
    colors.rgba.assign(4 * c.size(), 0);
    colors.valid.assign(c.size(), 0);
    size_t part = 0;
    const auto filter = [&](size_t l, std::uint16_t first, std::uint16_t last, float share) {
        const auto seen = [&](size_t i) { return s.surface[i] >= first && s.surface[i] <= last; };
        const auto distance = [&](size_t i) { return c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i]; };
        float least = 1e38f;
        for (size_t i = c.offset[l]; i < c.offset[l + 1]; ++i)
            if (seen(i)) least = std::min(least, distance(i));
        float sum[5] = {};
        for (size_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
            if (!seen(i)) continue;
            const float w = weight(distance(i), least, c.ratio_of(l));
            for (size_t k = 0; k < 4; ++k) sum[k] += w * h.rgba[4 * size_t(c.sample[i]) + k];
            sum[4] += w;
        }
        if (!(sum[4] > 0)) return;
        for (size_t k = 0; k < 4; ++k) colors.rgba[4 * l + k] += share * sum[k] / sum[4];
        colors.valid[l] = 1;
    };
    for (size_t l = 0; l < c.size(); ++l)
        if (v.decision[l] != Decision::undecided)
            v.each_seen(l, part, [&](std::uint16_t first, std::uint16_t last, float share) { filter(l, first, last, share); });
}

struct GaussianVisible {
    float sigma = 0.35f;

    static void declare(Ports<GaussianVisible>& node) {
        declare_filter(node, "filters the samples of the surface seen with a Gaussian");
        node.param("sigma", &GaussianVisible::sigma, {.unit = "R", .min = 0.01, .max = 16, .about = "standard deviation"});
    }
    void batch(const Inputs& in, Outputs& out) const {
        const float width = sigma * in.get<Candidates>("candidates").hierarchy->radius, k = -0.5f / (width * width);
        // Relative to the nearest sample, so that one at least counts however far it is.
        filter_each(in, out, [&](float d2, float least, float ratio) { return std::exp(k * (d2 - least) / (ratio * ratio)); });
    }
};

struct NearestVisible {
    static void declare(Ports<NearestVisible>& node) { declare_filter(node, "takes the nearest sample of the surface seen"); }
    void batch(const Inputs& in, Outputs& out) const {
        filter_each(in, out, [](float d2, float least, float) { return d2 <= least ? 1.0f : 0.0f; });
    }
};

WEFT_NODE(GaussianVisible, "gaussian-visible", 1)
WEFT_NODE(NearestVisible, "nearest-visible", 1)

}  // namespace
}  // namespace weft
