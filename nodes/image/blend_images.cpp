// blend-images: one picture where a third is low, another where it is high, and a step between.
#include <fmt/format.h>

#include <algorithm>

#include "image/image.h"
#include "image/image_cost.h"
#include "image/smooth_step.h"
#include "runtime/node.h"

namespace weft {
namespace {

enum class Step { smooth, linear };

struct BlendImages {
    float low = 0, high = 1;
    Step step = Step::smooth;

    static void declare(Ports<BlendImages>& node) {
        node.about("one picture or another, pixel by pixel, by the values of a third")
            .in<Image>("low", "the picture where 'by' is at most 'low'")
            .in<Image>("high", "the picture where it is at least 'high'; same size and channels")
            .in<Image>("by", "its first channel decides; same size")
            .out<Image>("image", "low + (high - low) s, s a step of 'by' from 0 to 1")
            .param("low", &BlendImages::low, {.about = "value of 'by' up to which the first picture is taken"})
            .param("high", &BlendImages::high, {.about = "value of 'by' from which on the second is taken"})
            .choice("step", &BlendImages::step, {"smooth", "linear"}, {.about = "how the one becomes the other between: 3 t^2 - 2 t^3, or t"});
    }

    Cost cost(const Shapes& in) const { return cost_like(in, "low", "image"); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image &a = in.get<Image>("low"), &b = in.get<Image>("high"), &by = in.get<Image>("by");
        if (!(low < high)) ctx.fail(fmt::format("low is {}, high is {}; expected low below high", low, high));
        if (a.width() != b.width() || a.height() != b.height() || a.names() != b.names() || by.width() != a.width() || by.height() != a.height() ||
            by.channels() < 1)
            ctx.fail(fmt::format("'low' is {} x {} with {}, 'high' {} x {} with {}, 'by' {} x {}; expected one size, and the same channels of the first two",
                                 a.width(), a.height(), fmt::join(a.names(), " "), b.width(), b.height(), fmt::join(b.names(), " "), by.width(),
                                 by.height()));
        Image result = a;
        ctx.parallel_rows(a.height(), [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < a.width(); ++x) {
                    const float s = step_of(*by.at(x, y));
                    for (int c = 0; c < a.channels(); ++c) {
                        // Taken as they are at the ends, so that what is not finite in the one does not reach the other.
                        const float first = a.at(x, y)[c], second = b.at(x, y)[c];
                        result.at(x, y)[c] = s <= 0 ? first : s >= 1 ? second : first + (second - first) * s;
                    }
                }
        });
        out.set("image", std::move(result));
    }

  private:
    float step_of(float by) const { return step == Step::smooth ? smooth_step(low, high, by) : std::clamp((by - low) / (high - low), 0.0f, 1.0f); }
};

WEFT_NODE(BlendImages, "blend-images", 1);

}  // namespace
}  // namespace weft
