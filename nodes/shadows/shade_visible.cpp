// shade-visible: adds a light to what other light there is: its unshadowed light at the receiver
// times the share of it that the receiver sees.
#include <fmt/format.h>

#include <algorithm>

#include "light-field/streams.h"
#include "runtime/node.h"
#include "shadows/streams.h"

namespace weft {
namespace {

struct ShadeVisible {
    static void declare(Ports<ShadeVisible>& node) {
        node.about("adds the light that arrives through a share of a light")
            .in<Colors>("colors", "all other light at each location")
            .in<LightShares>("shares", "how much of the light each location sees")
            .in<ShadowQueries>("queries", "which sample each location sees")
            .in<Samples>(
                "direct",
                "the camera's samples; rgb is what the light brings with nothing in its way")
            .out<Colors>("colors", "with the light");
    }
    void batch(const Inputs& in, Outputs& out) const {
        const Colors& colors = in.get<Colors>("colors");
        const LightShares& shares = in.get<LightShares>("shares");
        const ShadowQueries& queries = in.get<ShadowQueries>("queries");
        const Samples& direct = in.get<Samples>("direct");
        const auto rgb = direct.rgb();
        Colors& lit = out.get<Colors>("colors");
        const size_t n = colors.size();
        lit.color_space = colors.color_space;
        lit.rgba.resize(4 * n);
        lit.valid.assign(colors.valid.begin(), colors.valid.begin() + std::ptrdiff_t(n));
        for (size_t l = 0; l < n; ++l) {
            float* to = &lit.rgba[4 * l];
            std::copy_n(&colors.rgba[4 * l], 4, to);
            const std::uint32_t i = queries.sample[l];
            if (i == SeenSamples::none) continue;
            if (3 * size_t(i) + 2 >= rgb.size())
                throw Error(
                    fmt::format("'direct' has {} samples and no number {}; expected those that the "
                                "receivers were found in",
                                direct.size(), i));
            const size_t from = queries.answer_of.empty() ? l : queries.answer_of[l];
            const float share = shares.share[from] / queries.chance;
            for (size_t c = 0; c < 3; ++c) to[c] += share * rgb[3 * size_t(i) + c];
        }
    }
};

WEFT_NODE(ShadeVisible, "shade-visible", 1)

}  // namespace
}  // namespace weft
