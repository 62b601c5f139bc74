// reproject: the samples that land near each location at its (u, v, t).
// Source: Lehtinen et al. 2011, Sec. 3.1 and 3.2.  Departure: where a batch shares (u, v, t) its samples are
// projected once and sorted into a grid, instead of searched for location by location.
#include "light-field/kernels.h"
#include "light-field/local_radius.h"
#include "light-field/projected.h"
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

    using Scratch = ProjectedScratch;
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        const Locations& at = in.get<Locations>("locations");
        Candidates& found = out.get<Candidates>("candidates");
        const float largest = largest_radius(h, at), radius = radius_scale * largest;
        Projection* made = out.wanted("projection") ? &out.get<Projection>("projection") : nullptr;
        if (!at.shared) {
            gather_around(h, at, radius_scale, scratch.block, found);
            if (made) made->hierarchy = nullptr, made->samples = 0;
            return;
        }
        const Projection* known = in.find<Projection>("projection");
        WEFT_PICK(gather)(projected(h, at, radius, std::max(reach, radius_scale) * largest, false, known, made, scratch), at, radius, found);
        narrow(radius_scale, at, found);
    }
};

WEFT_NODE(Reproject, "reproject", 1)

}  // namespace
}  // namespace weft
