// The surfaces among a location's candidates, front to back. For kernels (weft_kernels).
#pragma once
#include <algorithm>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {

// Adds 1 where the mask holds.
template <class M>
HWY_INLINE VI one_more(VI count, M mask) {
#if HWY_MAX_BYTES == 64
    return VI{_mm512_mask_sub_epi32(count.raw, mask.raw, count.raw, _mm512_set1_epi32(-1))};
#else
    return hn::Sub(count, hn::VecFromMask(sn, hn::RebindMask(sn, mask)));
#endif
}

// Place of each in order of depth; equal ones keep their order.
HWY_INLINE void rank_by_depth(const float* depth, size_t n, std::uint32_t* rank) {
    for (size_t i = 0; i < n; i += lanes) {
        const VF mine = hn::LoadU(f, depth + i);
        VI place = hn::Zero(sn);
        const auto count = [&](auto mask) HWY_ATTR { place = one_more(place, mask); };
        // Those that come before all of these in order win ties, those after lose them.
        size_t j = 0;
        for (; j < i; ++j) count(hn::Le(hn::Set(f, depth[j]), mine));
        for (const size_t end = std::min(i + lanes, n); j < end; ++j) {
            const VF other = hn::Set(f, depth[j]);
            count(hn::Or(hn::Lt(other, mine),
                         hn::AndNot(hn::FirstN(f, j - i + 1), hn::Eq(other, mine))));
        }
        for (; j < n; ++j) count(hn::Lt(hn::Set(f, depth[j]), mine));
        hn::StoreU(hn::BitCast(un, place), un, rank + i);
    }
}

// The candidates of one location, nearest first, and what they do there. Slopes and velocities are
// scaled by the box, so that a difference is the way two samples move against each other inside it.
struct Layers {
    const SeeScratch& c;
    const size_t n;
    const float aspect, tolerance;
    const bool velocities;  // whether these can tell any two apart

    // Where the surface that begins at `open` ends: at the first that conflicts with one of it.
    size_t next(size_t open) const {
        return velocities ? next_of<true>(open) : next_of<false>(open);
    }

  private:
    template <bool moving>
    size_t next_of(size_t open) const {
        bool mixed = false;  // a sample that moves unlike the first is among the surface's: all
                             // that follow are suspect
        for (size_t i = open; i < n; i += lanes) {
            if (!mixed && !suspects<moving>(i, open)) continue;
            mixed = moving;
            if (const unsigned bits = conflicts<moving>(i, open))
                return i + size_t(__builtin_ctz(bits));
        }
        return n;
    }

    // Whether one of [i, i + lanes) may conflict with some of those from `open` on that are nearer:
    // slopes ascend with depth or descend with it, so that of the first differs most; of
    // velocities, none differ by more than twice what they differ from the first by.
    template <bool moving>
    HWY_INLINE bool suspects(size_t i, size_t open) const {
        const VF limit = hn::Set(f, tolerance / std::max(1.0f, aspect)),
                 half = hn::Set(f, 0.5f * tolerance);
        auto found =
            hn::Gt(hn::AbsDiff(hn::LoadU(f, &c.slope[i]), hn::Set(f, c.slope[open])), limit);
        if constexpr (moving) {
            found = hn::Or(found, hn::Gt(hn::AbsDiff(hn::LoadU(f, &c.velocity_x[i]),
                                                     hn::Set(f, c.velocity_x[open])),
                                         half));
            found = hn::Or(found, hn::Gt(hn::AbsDiff(hn::LoadU(f, &c.velocity_y[i]),
                                                     hn::Set(f, c.velocity_y[open])),
                                         half));
        }
        return !hn::AllFalse(f, hn::And(found, hn::FirstN(f, n - i)));
    }

    // Which of [i, i + lanes) conflict with one of those before it, from `open` on.
    template <bool moving>
    HWY_INLINE unsigned conflicts(size_t i, size_t open) const {
        const VF limit = hn::Set(f, tolerance), stretch = hn::Set(f, aspect);
        const VF x = hn::LoadU(f, &c.x[i]), y = hn::LoadU(f, &c.y[i]),
                 slope = hn::LoadU(f, &c.slope[i]);
        const VF vx = moving ? hn::LoadU(f, &c.velocity_x[i]) : slope,
                 vy = moving ? hn::LoadU(f, &c.velocity_y[i]) : slope;
        const auto cross = [&](size_t j) HWY_ATTR {
            VF way_y = hn::AbsDiff(hn::Set(f, c.slope[j]), slope), way_x = hn::Mul(way_y, stretch);
            if constexpr (moving) {
                way_x = hn::Max(way_x, hn::AbsDiff(hn::Set(f, c.velocity_x[j]), vx));
                way_y = hn::Max(way_y, hn::AbsDiff(hn::Set(f, c.velocity_y[j]), vy));
            }
            return hn::Or(hn::Lt(hn::Add(hn::AbsDiff(hn::Set(f, c.x[j]), x), limit), way_x),
                          hn::Lt(hn::Add(hn::AbsDiff(hn::Set(f, c.y[j]), y), limit), way_y));
        };
        auto found = hn::MaskFromVec(hn::Zero(f));
        for (size_t j = open; j < i; ++j) found = hn::Or(found, cross(j));
        for (size_t j = i, end = std::min(i + lanes, n); j < end; ++j)
            found = hn::Or(found, hn::AndNot(hn::FirstN(f, j - i + 1), cross(j)));
        return bits_of(f, hn::And(found, hn::FirstN(f, n - i)));
    }
};

}  // namespace weft::light_field::WEFT_ISA
