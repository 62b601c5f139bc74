// nearest-sample: for locations that have no sample around them: the one sample that lands nearest, searched
// for ever farther out. Source: Lehtinen et al. 2011, Sec. 3.4 (holes); the radius is doubled up to `reach`.
#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace light_field;

struct NearestSample {
    float reach = 16;

    static void declare(Ports<NearestSample>& node) {
        node.about("the radiance of the sample that lands nearest to each location")
            .in<Locations>("locations", "points to serve")
            .in<Hierarchy>("hierarchy", "the samples")
            .out<Colors>("colors", "not valid where there is no sample within reach")
            .param("reach", &NearestSample::reach, {.unit = "R", .min = 1, .max = 1e4, .about = "how far out a sample may be"});
    }
    struct Scratch {
        Block block;
        Candidates candidates;
        Locations one;
    };
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        const Locations& at = in.get<Locations>("locations");
        Colors& colors = out.get<Colors>("colors");
        h.require_colors();
        colors.color_space = &h.color_space;
        colors.rgba.assign(4 * at.size(), 0);
        colors.valid.assign(at.size(), 0);
        Candidates& c = scratch.candidates;
        for (size_t l = 0; l < at.size(); ++l) {
            Locations& one = scratch.one;
            one.x.assign(1, at.x[l]);
            one.y.assign(1, at.y[l]);
            one.u.assign(1, at.u_of(l));
            one.v.assign(1, at.v_of(l));
            one.t.assign(1, at.t_of(l));
            one.pixels = at.pixels.subspan(l, 1);
            c.pixels = one.pixels;
            for (float radius = 2; !colors.valid[l]; radius *= 2) {
                const float within = std::min(radius, reach) * h.radius_at(at.x[l], at.y[l]);
                // By pixels, so that a neighbour's search finds the same groups ready.
                const int x = int(std::floor(at.x[l])), y = int(std::floor(at.y[l]));
                if (!scratch.block.covers(h, x, y, x + 1, y + 1, within)) collect(h, x, y, x + 1, y + 1, within, scratch.block);
                WEFT_PICK(gather_each)(h, scratch.block, one, within, c);
                float least = 1e38f;
                for (size_t i = 0; i < c.offset[1]; ++i) {
                    const float d2 = c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i];
                    if (!(d2 < least)) continue;
                    least = d2;
                    std::copy_n(&h.rgba[4 * size_t(c.sample[i])], 4, &colors.rgba[4 * l]);
                    colors.valid[l] = 1;
                }
                if (radius >= reach) break;
            }
        }
    }
};

WEFT_NODE(NearestSample, "nearest-sample", 1)

}  // namespace
}  // namespace weft
