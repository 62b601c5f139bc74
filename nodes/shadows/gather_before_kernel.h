// The light samples near each of some rays that stand before what it meets.
#pragma once
#include <span>

#include "light-field/kernels.h"
#include "light-field/streams.h"
#include "runtime/isa.h"
#include "shadows/light_view.h"
#include "shadows/streams.h"

namespace weft::shadows {

// What gather_each() finds within `scale` R of each location, as far as it is before the receiver
// by both planes (Planes::before).
//   nearest   of each of the hierarchy's groups the greatest 1/w
#define WEFT_GATHER_BEFORE_KERNELS(isa)                                                          \
    namespace isa {                                                                              \
    void gather_before(const Hierarchy& hits, const light_field::Block& block,                   \
                       std::span<const float> nearest, const LightView& view,                    \
                       const Locations& locations, const ShadowQueries& queries, float scale,    \
                       float bias, Candidates& out);                                             \
    }
WEFT_GATHER_BEFORE_KERNELS(v2)
WEFT_GATHER_BEFORE_KERNELS(v3)
WEFT_GATHER_BEFORE_KERNELS(v4)

}  // namespace weft::shadows
