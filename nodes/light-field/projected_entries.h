// The entries of a projection as vectors. For kernels (weft_kernels).
#pragma once
#include "light-field/simd.h"
#include "light-field/streams.h"

namespace weft::light_field::WEFT_ISA {

// As many entries as there are lanes, transposed within blocks of four lanes: lane 4 k + j holds entry
// j lanes / 4 + k. Broadcast<j> then gives each of what lies at j lanes / 4 and on, four values an
// entry, its own.
class EntryVectors {
  public:
    HWY_INLINE explicit EntryVectors(const Projection::Entry* from) {
        const float* at = &from->x;
        const VF a = hn::LoadU(f, at), b = hn::LoadU(f, at + lanes), c = hn::LoadU(f, at + 2 * lanes),
                 d = hn::LoadU(f, at + 3 * lanes);
        places_[0] = pairs(hn::InterleaveLower(f, a, b));
        places_[1] = pairs(hn::InterleaveLower(f, c, d));
        rest_[0] = pairs(hn::InterleaveUpper(f, a, b));
        rest_[1] = pairs(hn::InterleaveUpper(f, c, d));
    }
    HWY_INLINE VF x() const { return hn::BitCast(f, hn::InterleaveLower(two, places_[0], places_[1])); }
    HWY_INLINE VF y() const { return hn::BitCast(f, hn::InterleaveUpper(two, places_[0], places_[1])); }
    HWY_INLINE VU sample() const { return hn::BitCast(un, hn::InterleaveLower(two, rest_[0], rest_[1])); }
    HWY_INLINE VU traits() const { return hn::BitCast(un, hn::InterleaveUpper(two, rest_[0], rest_[1])); }

  private:
    using Two = hn::Repartition<std::uint64_t, F>;
    static constexpr Two two{};
    HWY_INLINE static hn::Vec<Two> pairs(VF v) { return hn::BitCast(two, v); }
    hn::Vec<Two> places_[2], rest_[2];
};

// Brings lanes from the order of EntryVectors into that of the entries.
struct EntryOrder {
    alignas(64) std::array<std::int32_t, lanes> of{};
    constexpr EntryOrder() {
        for (size_t entry = 0; entry < lanes; ++entry)
            of[entry] = std::int32_t(4 * (entry % (lanes / 4)) + entry / (lanes / 4));
    }
};
inline constexpr EntryOrder entry_order;
HWY_INLINE VU in_order(VU v) {
    return hn::TableLookupLanes(v, hn::SetTableIndices(un, entry_order.of.data()));
}
HWY_INLINE VF in_order(VF v) {
    return hn::TableLookupLanes(v, hn::SetTableIndices(f, entry_order.of.data()));
}

}  // namespace weft::light_field::WEFT_ISA
