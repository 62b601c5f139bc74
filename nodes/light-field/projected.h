// The samples around a batch at its common (u, v, t), projected once for all stages that ask.
#pragma once
#include "light-field/kernels.h"
#include "light-field/local_radius.h"

namespace weft::light_field {

struct ProjectedScratch {
    Block block;
    Projection projection;
    // What the projection last made, here or elsewhere, is of.
    const Hierarchy* hierarchy = nullptr;
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

// Brings together the groups that may be seen within `reach` of the batch's pixels.
inline void collect_for(const Hierarchy& h, const Locations& at, float reach, Block& block) {
    if (!block.covers(h, at.x0, at.y0, at.x1, at.y1, reach))
        collect(h, at.x0, at.y0, at.x1, at.y1, reach, block);
}

// The samples within `scale` R of each location, which share no (u, v, t).
inline void gather_around(const Hierarchy& h, const Locations& at, float scale, Block& block,
                          Candidates& found) {
    const float radius = scale * largest_radius(h, at);
    collect_for(h, at, radius, block);
    WEFT_PICK(gather_each)(h, block, at, radius, found);
    narrow(scale, at, found);
}

// `known`, if it is of this batch and holds all samples within `radius`; else a projection of all
// within `reach`, made in `to` (in the scratch where that is null) unless it is there already. With
// `colors` their colours too.
inline const Projection& projected(const Hierarchy& h, const Locations& at, float radius,
                                   float reach, bool colors, const Projection* known,
                                   Projection* to, ProjectedScratch& scratch) {
    const auto of_this = [&](const Projection& p) {
        return p.u == at.u[0] && p.v == at.v[0] && p.t == at.t[0] && (p.colored || !colors);
    };
    if (known && known->hierarchy == &h && known->reach >= radius && of_this(*known)) return *known;
    Projection& p = to ? *to : scratch.projection;
    const bool same_block = scratch.hierarchy == &h && scratch.x0 == at.x0 && scratch.y0 == at.y0 &&
                            scratch.x1 == at.x1 && scratch.y1 == at.y1;
    p.kept = same_block && of_this(p) && p.reach >= radius;
    if (p.kept) return p;
    collect_for(h, at, reach, scratch.block);
    WEFT_PICK(project)(h, scratch.block, at.u[0], at.v[0], at.t[0], colors, p);
    scratch.hierarchy = &h;
    scratch.x0 = at.x0;
    scratch.y0 = at.y0;
    scratch.x1 = at.x1;
    scratch.y1 = at.y1;
    return p;
}

}  // namespace weft::light_field
