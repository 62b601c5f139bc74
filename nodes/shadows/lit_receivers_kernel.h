// Which receivers see all of a light: nothing that the light sees comes near any way from one of its
// points to the receiver, at any time. No vote of the rays around (ray_vote_kernel.h) could come out
// otherwise, so their locations need not ask.
// Source: own.  Cost: a search a group of receivers and a glance at a few groups of light samples
// each, some 0.2 us a receiver.  Threads: each call touches its own outputs only.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "light-field/hierarchy.h"
#include "runtime/isa.h"
#include "shadows/receivers.h"

namespace weft::shadows {

// Where groups of light samples are as the middle of the light sees them, over the whole shutter.
struct LightBounds {
    std::vector<float> x_low, x_high, y_low, y_high;  // px
    std::vector<float> nearest;                       // the greatest 1/w
    // Of the hierarchy's own groups: that of a plane, which is `top` at the middle of the bounds and rises by
    // `rise_x`, `rise_y` a px, before which nothing of them lies.
    std::vector<float> top, rise_x, rise_y;
    std::vector<std::uint32_t> group;                 // which these are of; empty: all, in order
    size_t size = 0;  // the arrays are longer by whole vectors of what is nowhere

    void resize(size_t n);
    static constexpr size_t spare = 16;
};

// The hierarchy's own groups, and level by level these by `Hierarchy::fan_out`: two levels at least,
// the last of some vectors.
std::vector<LightBounds> bounds_of(const Hierarchy& hits);

// A receiver that stands still, as the middle of the light sees it.
struct StillReceiver {
    float x_low, x_high, y_low, y_high;  // px; what stands still moves by rounding
    float far, near;                     // 1/w
    float slope_x, slope_y;              // of 1/w a px, of its plane
    float radius;                        // px: how far is looked for light samples
    float turn;    // the least by which slopes are divided at points of the light (planes.h)
    float behind;  // how much less 1/w than the receiver's is may be before its plane within reach
};

struct LitSettings {
    float c0x = 0, c0y = 0;  // px a unit of 1/w from the light's middle to where it ends
    bool round = false;      // that is: a disc, else a rectangle
    float px = 0;            // 1/w a unit of 1/w, by which what bends may rise a px
    float bias = 0;          // relative: what is nearer by less does not count
    float search = 1;  // of the radius: how far the vote looks, and others less far than the radius
    float sure = 1;    // of that, within which a light sample is near by any metric
};

struct LitScratch {
    LightBounds near;
    std::vector<std::uint32_t> open, below;  // of levels above the groups
    std::vector<std::uint32_t> others;       // groups that stop no light of a receiver
};

#define WEFT_LIT_RECEIVERS_KERNELS(isa)                                                          \
    namespace isa {                                                                              \
    /* 0, or 1 where nothing comes within `search`, or 2 where nothing comes within the radius. */ \
    /* Receivers of a call should be neighbours. */                                              \
    void find_lit(const Hierarchy& hits, std::span<const LightBounds> levels, const LitSettings& set, \
                  std::span<const StillReceiver> receivers, LitScratch& scratch,                 \
                  std::uint8_t* lit);                                                            \
    }
WEFT_LIT_RECEIVERS_KERNELS(v2)
WEFT_LIT_RECEIVERS_KERNELS(v3)
WEFT_LIT_RECEIVERS_KERNELS(v4)

}  // namespace weft::shadows
