// multiply-visibility: a light's picture from how much of it each pixel sees: what it brings
// unshadowed times that share, added to all other light. Texture and gloss stay as sharp as they
// are, since neither was filtered.
#include <fmt/format.h>

#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct MultiplyVisibility {
    static void declare(Ports<MultiplyVisibility>& node) {
        node.about("a light's unshadowed picture times the share of it that is seen")
            .in<Image>("visibility", "Y: share seen; or as many channels as 'light'")
            .in<Image>("light", "what the light brings with nothing in its way; same size")
            .in<Image>("rest", "all other light; same size and channels as 'light'", Need::optional)
            .out<Image>("image", "rest + light x visibility");
    }
    Cost cost(const Shapes& in) const { return cost_like(in, "light", "image"); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image &visibility = in.get<Image>("visibility"), &light = in.get<Image>("light");
        const Image* rest = in.find<Image>("rest");
        const auto check = [&](const Image& image, const char* port, bool one) {
            if (image.width() != light.width() || image.height() != light.height() ||
                (image.channels() != light.channels() && !(one && image.channels() == 1)))
                ctx.fail(fmt::format(
                    "'{}' is {} x {} with {} channels, 'light' {} x {} with {}; "
                    "expected one size and the same channels{}",
                    port, image.width(), image.height(), image.channels(), light.width(),
                    light.height(), light.channels(), one ? ", or one" : ""));
        };
        check(visibility, "visibility", true);
        if (rest) check(*rest, "rest", false);
        Image image = light;
        const auto channels = size_t(light.channels()),
                   step = size_t(visibility.channels() > 1 ? 1 : 0);
        ctx.parallel_rows(light.height(), [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < light.width(); ++x)
                    for (size_t c = 0; c < channels; ++c)
                        image.at(x, y)[c] = (rest ? rest->at(x, y)[c] : 0.0f) +
                                            light.at(x, y)[c] * visibility.at(x, y)[c * step];
        });
        out.set("image", std::move(image));
    }
};

WEFT_NODE(MultiplyVisibility, "multiply-visibility", 1)

}  // namespace
}  // namespace weft
