// exposure: scene-linear colour times 2^stops, and a gain a channel. Alpha and channels that are
// no colour stay.
#include <cmath>

#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct Exposure {
    float stops = 0;
    std::array<float, 3> gain = {1, 1, 1};

    static void declare(Ports<Exposure>& node) {
        node.about("makes a scene-linear picture brighter or darker")
            .in<Image>("image", "a scene-linear picture")
            .out<Image>("image", "R, G, B (or Y) times 2^stops times gain")
            .param("stops", &Exposure::stops,
                   {.unit = "stops", .min = -64, .max = 64, .about = "1 doubles, -1 halves"})
            .param("gain", &Exposure::gain,
                   {.min = 0, .about = "of red, green and blue (Y: of green)"});
    }

    Cost cost(const Shapes& in) const { return cost_like(in, "image", "image"); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        Image image = in.get<Image>("image");
        const float scale = std::exp2(stops);
        std::vector<float> factors(size_t(image.channels()), 1.0f);
        for (size_t c = 0; c < factors.size(); ++c) {
            const size_t color = std::string_view("RGBY").find(image.names()[c]);
            if (color != std::string_view::npos && image.names()[c].size() == 1)
                factors[c] = scale * gain[color == 3 ? 1 : color];
        }
        ctx.parallel_rows(image.height(), [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y) {
                float* pixel = image.row(y);
                for (int x = 0; x < image.width(); ++x)
                    for (size_t c = 0; c < factors.size(); ++c) *pixel++ *= factors[c];
            }
        });
        out.set("image", std::move(image));
    }
};

WEFT_NODE(Exposure, "exposure", 1);

}  // namespace
}  // namespace weft
