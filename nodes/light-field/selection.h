// Some of a batch's locations, as a batch of its own.
#pragma once
#include "light-field/streams.h"

namespace weft::light_field {

// Those whose decision is `which`; their parents are indices into `from`.
inline void select(const Locations& from, const Visibility& visibility, Decision which, Locations& to) {
    to.x.clear();
    to.y.clear();
    to.ratio.clear();
    to.own_pixels.clear();
    to.own_parents.clear();
    to.shared = from.shared;
    to.number = from.number;
    to.x0 = from.x0;
    to.y0 = from.y0;
    to.x1 = from.x1;
    to.y1 = from.y1;
    const std::ptrdiff_t sets = from.shared ? 1 : 0;
    to.u.assign(from.u.begin(), from.u.begin() + sets);
    to.v.assign(from.v.begin(), from.v.begin() + sets);
    to.t.assign(from.t.begin(), from.t.begin() + sets);
    for (size_t l = 0; l < from.size(); ++l) {
        if (visibility.decision[l] != which) continue;
        to.x.push_back(from.x[l]);
        to.y.push_back(from.y[l]);
        to.own_pixels.push_back(from.pixels[l]);
        to.own_parents.push_back(std::uint32_t(l));
        if (!from.ratio.empty()) to.ratio.push_back(from.ratio[l]);
        if (from.shared) continue;
        to.u.push_back(from.u[l]);
        to.v.push_back(from.v[l]);
        to.t.push_back(from.t[l]);
    }
    to.pixels = to.own_pixels;
    to.parents = to.own_parents;
}

}  // namespace weft::light_field
