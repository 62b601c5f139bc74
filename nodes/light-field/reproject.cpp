// reproject: the samples that land near each location at its (u, v, t).
// Source: Lehtinen et al. 2011, Sec. 3.1 and 3.2.  Departure: where a batch shares (u, v, t) its samples are
// projected once and sorted into a grid, instead of searched for location by location.
#include "light-field/kernels.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace light_field;

struct Reproject {
    float radius_scale = 1, reach = 2;

    static void declare(Ports<Reproject>& node) {
        node.about("the samples within a radius of each location, at its lens position and time")
            .in<Locations>("locations", "points to serve")
            .in<Hierarchy>("hierarchy", "the samples")
            .in<Projection>("projection", "of an earlier reproject of the same batch, to save projecting again", Need::optional)
            .out<Candidates>("candidates", "the samples near each location")
            .out<Projection>("projection", "all samples around the batch, for others")
            .param("radius-scale", &Reproject::radius_scale, {.unit = "R", .min = 0.05, .max = 32, .about = "radius of the search"})
            .param("reach", &Reproject::reach,
                   {.unit = "R", .min = 0.05, .max = 64, .about = "how far around the batch's pixels samples are projected; the largest radius asked for later"});
    }

    struct Scratch {
        Block block;
        Projection projection;
        const Hierarchy* hierarchy = nullptr;  // of the projection held, with its block and (u, v, t)
        int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    };

    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        const Locations& at = in.get<Locations>("locations");
        Candidates& found = out.get<Candidates>("candidates");
        const float radius = radius_scale * h.radius, needed = std::max(reach, radius_scale) * h.radius;
        if (!at.shared) {
            cover(h, at, radius, scratch.block);
            WEFT_PICK(gather_each)(h, scratch.block, at, radius, found);
            if (out.wanted("projection")) out.get<Projection>("projection").hierarchy = nullptr;
            return;
        }
        const Projection* known = in.find<Projection>("projection");
        if (known && known->hierarchy == &h && known->reach >= radius && known->u == at.u[0] && known->v == at.v[0] && known->t == at.t[0]) {
            WEFT_PICK(gather)(*known, at, radius, found);
            return;
        }
        Projection& projection = out.wanted("projection") ? out.get<Projection>("projection") : scratch.projection;
        const bool same_block = scratch.hierarchy == &h && scratch.x0 == at.x0 && scratch.y0 == at.y0 &&
                                scratch.x1 == at.x1 && scratch.y1 == at.y1;
        if (!same_block || projection.u != at.u[0] || projection.v != at.v[0] || projection.t != at.t[0]) {
            cover(h, at, needed, scratch.block);
            WEFT_PICK(project)(h, scratch.block, at.u[0], at.v[0], at.t[0], projection);
            scratch.hierarchy = &h;
            scratch.x0 = at.x0;
            scratch.y0 = at.y0;
            scratch.x1 = at.x1;
            scratch.y1 = at.y1;
        }
        WEFT_PICK(gather)(projection, at, radius, found);
    }

    static void cover(const Hierarchy& h, const Locations& at, float reach, Block& block) {
        if (!block.covers(h, at.x0, at.y0, at.x1, at.y1, reach)) collect(h, at.x0, at.y0, at.x1, at.y1, reach, block);
    }
};

WEFT_NODE(Reproject, "reproject", 1)

}  // namespace
}  // namespace weft
