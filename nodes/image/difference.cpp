// difference: one picture minus another, value by value; its sign is kept.
#include <fmt/format.h>

#include <cmath>

#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct Difference {
    float gain = 1;
    bool absolute = false;

    static void declare(Ports<Difference>& node) {
        node.about("the difference of two pictures")
            .in<Image>("image", "a picture")
            .in<Image>("reference", "what is taken from it; same size and channels")
            .out<Image>("image", "gain * (image - reference)")
            .param("gain", &Difference::gain, {.about = "factor"})
            .param("absolute", &Difference::absolute, {.about = "without its sign"});
    }

    Cost cost(const Shapes& in) const { return cost_like(in, "image", "image"); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image &a = in.get<Image>("image"), &b = in.get<Image>("reference");
        if (a.width() != b.width() || a.height() != b.height() || a.names() != b.names())
            ctx.fail(fmt::format("a picture of {} x {} with {} and one of {} x {} with {}",
                                 a.width(), a.height(), fmt::join(a.names(), " "), b.width(),
                                 b.height(), fmt::join(b.names(), " ")));
        Image result = a;
        ctx.parallel_rows(a.height(), [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (size_t i = 0; i < a.stride(); ++i) {
                    const float d = gain * (a.row(y)[i] - b.row(y)[i]);
                    result.row(y)[i] = absolute ? std::abs(d) : d;
                }
        });
        out.set("image", std::move(result));
    }
};

WEFT_NODE(Difference, "difference", 1);

}  // namespace
}  // namespace weft
