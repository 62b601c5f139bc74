// The sample that each location sees: of the surface that it sees, the one that lands nearest.
// Source: Lehtinen et al. 2011, Sec. 4: a shadow is asked for at a sample's own place, as a mean of
// several depths could hang in mid-air.
#pragma once
#include "light-field/location_number.h"
#include "light-field/streams.h"
#include "shadows/streams.h"

namespace weft::shadows {

// None where it is not decided which surface is seen; of several surfaces one, as often as its
// share says.
inline void find_seen(const Candidates& c, const Surfaces& s, const Visibility& v,
                      SeenSamples& seen) {
    seen.sample.assign(c.size(), SeenSamples::none);
    size_t part = 0;
    for (size_t l = 0; l < c.size(); ++l) {
        std::uint16_t first = 0, last = 0;
        float left = v.decision[l] == Decision::partly
                         ? light_field::location_number(c.x[l], c.y[l], c.u_of(l), c.t_of(l))
                         : 0.0f;
        bool chosen = false;
        v.each_seen(l, part, [&](std::uint16_t from, std::uint16_t to, float share) {
            if (chosen) return;
            first = from, last = to;
            left -= share;
            chosen = left < 0;
        });
        if (v.decision[l] == Decision::undecided) continue;
        float least = 1e38f;
        for (std::uint32_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
            if (s.surface[i] < first || s.surface[i] > last) continue;
            const float d2 = c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i];
            if (d2 < least) least = d2, seen.sample[l] = c.sample[i];
        }
    }
}

}  // namespace weft::shadows
