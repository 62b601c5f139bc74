// blur-width: how wide a picture may be filtered where motion or defocus blurs it anyway: the width
// that axis-aligned-filter takes. Of what the window's integral leaves at the band limit W, a
// Gaussian of these widths takes little: at a wavelength of 16 px, moving by 8, it loses 6 % of the
// amplitude that is left.
//   motion  along the way of it, deviation |s|_min / 9 px
//   lens    all round, 0.18 |coc|_min px
// Source: Egan et al. 2009, Sec. 5; the constants are derived from the bands in slopes.h.
#include "adaptive/slopes.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

struct BlurWidth {
    enum class Effect { motion, lens };
    Effect effect = Effect::motion;

    static void declare(Ports<BlurWidth>& node) {
        node.about("how wide 'axis-aligned-filter' may filter what motion or defocus blurs")
            .in<Image>("slopes", "of slope-bounds, of that effect")
            .out<Image>("width",
                        "beta: px, 0 where something stands still, or is in focus; of motion also "
                        "n.x, n.y: along which")
            .choice("effect", &BlurWidth::effect, {"motion", "lens"}, {.about = "what blurs"});
    }
    Cost cost(const Shapes& in) const {
        return cost_like(in, "slopes", "width", effect == Effect::motion ? 3 : 1);
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& slopes = in.get<Image>("slopes");
        const SlopeReader read(slopes, "blur-width");
        const bool motion = effect == Effect::motion;
        if (motion ? !read.motion() : !read.lens())
            ctx.fail(motion ? "the slopes hold no motion; set effect of slope-bounds to both"
                            : "the slopes hold no lens; set effect of slope-bounds to both");
        Image width(slopes.width(), slopes.height(),
                    motion ? std::vector<std::string>{"beta", "n.x", "n.y"}
                           : std::vector<std::string>{"beta"});
        width.color_space = "Raw";
        ctx.parallel_rows(slopes.height(), [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < slopes.width(); ++x) {
                    const PixelSlopes s = read(x, y);
                    if (!s.known) continue;
                    float* w = width.at(x, y);
                    const double deviation = motion ? s.least() / 9 : 0.18 * s.lens_least();
                    w[0] = float(deviation * std::sqrt(6.0));  // exp(-3 (D / beta)^2)
                    if (motion) w[1] = float(s.nx), w[2] = float(s.ny);
                }
        });
        out.set("width", std::move(width));
    }
};

WEFT_NODE(BlurWidth, "blur-width", 1)

}  // namespace
}  // namespace weft
