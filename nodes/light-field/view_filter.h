// Reading a surface's radiance where it depends on the place on the lens and the time it is seen
// at: gloss, mirrors, shadows that pass over.
#pragma once
#include "light-field/kernels.h"

namespace weft::light_field {

// filter() for surfaces that differ by more than noise over (u, v, t). A plane over these is fitted
// to all candidates of the surface; F is the variance that it explains over what is left, each by
// its degrees of freedom. Above `test` the tent's mean moves along the plane to the location's own
// (u, v, t), by 1 - test / F of the way and never far beyond what candidates have, nor below 0
// where none is. Where the hierarchy has no uv and t it is filter().
// Source: none; Lehtinen et al. 2011 take radiance to be constant along a trajectory. The fit is
// the usual least squares with its F test.
void filter_by_view(const Candidates& c, const Surfaces& s, const Visibility& visibility,
                    const Tent& tent, float test, Colors& out);

}  // namespace weft::light_field
