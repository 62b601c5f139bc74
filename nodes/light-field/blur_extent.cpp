// blur-extent: how far lens and shutter spread what each pixel sees: the root mean square of its samples' distances from
// where they are seen at lens centre and half time. Where that is below a pixel's own width the light field is constant
// over lens and shutter, and there is nothing for a reconstruction of it to gain.
#include <algorithm>
#include <cmath>

#include "image/image.h"
#include "light-field/build_hierarchy_kernel.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace light_field;

struct BlurExtent {
    int radius = 1;

    static void declare(Ports<BlurExtent>& node) {
        node.about("how far lens and shutter spread what each pixel sees")
            .in<Samples>("samples", "xy and z; uv with a lens, t and motion where it has them")
            .out<Image>("image", "Y: px, root mean square over the pixel's samples")
            .param("radius", &BlurExtent::radius, {.unit = "px", .min = 0, .max = 16, .about = "pixels around whose samples count as well"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        const double pixels = double(s.width) * double(s.height);
        return {{{"image", {s.width, s.height, 1, 0, 4 * pixels}}}, 8 * pixels, 0};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        samples.require("blur-extent", {"xy", "z"});
        const Lens lens = samples.has_lens() ? *samples.lens : Lens{};
        const Places places = places_of(samples);
        const int width = samples.width, height = samples.height;
        std::vector<float> sum(samples.pixels()), count(samples.pixels());
        ctx.parallel_for(
            samples.pixels(),
            [&](size_t pixel) {
                const auto [begin, end] = samples.of_pixel(pixel);
                for (size_t i = begin; i < end; ++i) {
                    const Recentred p = recentred(places, lens, i);
                    if (!(p.W > 0)) continue;
                    const float dx = p.X / p.W - places.xy[2 * i], dy = p.Y / p.W - places.xy[2 * i + 1];
                    sum[pixel] += dx * dx + dy * dy;
                    count[pixel] += 1;
                }
            },
            256);
        Image image(width, height, 1);
        ctx.parallel_rows(height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < width; ++x) {
                    float squares = 0, n = 0;
                    for (int j = std::max(0, y - radius); j <= std::min(height - 1, y + radius); ++j)
                        for (int i = std::max(0, x - radius); i <= std::min(width - 1, x + radius); ++i) {
                            squares += sum[size_t(j) * size_t(width) + size_t(i)];
                            n += count[size_t(j) * size_t(width) + size_t(i)];
                        }
                    *image.at(x, y) = n > 0 ? std::sqrt(squares / n) : 0.0f;
                }
        });
        out.set("image", std::move(image));
    }
};

WEFT_NODE(BlurExtent, "blur-extent", 1)

}  // namespace
}  // namespace weft
