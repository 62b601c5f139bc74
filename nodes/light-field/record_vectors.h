// Records of four values, side by side in memory, as vectors. For kernels (weft_kernels).
#pragma once
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {

// As many records as there are lanes, transposed within blocks of four lanes: lane 4 k + j holds
// record j lanes / 4 + k. Broadcast<j> then gives each of what lies at j lanes / 4 and on, four
// values a record, its own.
class RecordVectors {
  public:
    HWY_INLINE explicit RecordVectors(const float* at) {
        const VF a = hn::LoadU(f, at), b = hn::LoadU(f, at + lanes),
                 c = hn::LoadU(f, at + 2 * lanes), d = hn::LoadU(f, at + 3 * lanes);
        low_[0] = pairs(hn::InterleaveLower(f, a, b));
        low_[1] = pairs(hn::InterleaveLower(f, c, d));
        high_[0] = pairs(hn::InterleaveUpper(f, a, b));
        high_[1] = pairs(hn::InterleaveUpper(f, c, d));
    }
    HWY_INLINE VF first() const { return values(hn::InterleaveLower(two, low_[0], low_[1])); }
    HWY_INLINE VF second() const { return values(hn::InterleaveUpper(two, low_[0], low_[1])); }
    HWY_INLINE VF third() const { return values(hn::InterleaveLower(two, high_[0], high_[1])); }
    HWY_INLINE VF fourth() const { return values(hn::InterleaveUpper(two, high_[0], high_[1])); }

  private:
    using Two = hn::Repartition<std::uint64_t, F>;
    static constexpr Two two{};
    HWY_INLINE static hn::Vec<Two> pairs(VF v) { return hn::BitCast(two, v); }
    HWY_INLINE static VF values(hn::Vec<Two> v) { return hn::BitCast(f, v); }
    hn::Vec<Two> low_[2], high_[2];
};

// Brings lanes from the order of RecordVectors into that of the records.
struct RecordOrder {
    alignas(64) std::array<std::int32_t, lanes> of{};
    constexpr RecordOrder() {
        for (size_t record = 0; record < lanes; ++record)
            of[record] = std::int32_t(4 * (record % (lanes / 4)) + record / (lanes / 4));
    }
};
inline constexpr RecordOrder record_order;
HWY_INLINE VU in_order(VU v) {
    return hn::TableLookupLanes(v, hn::SetTableIndices(un, record_order.of.data()));
}
HWY_INLINE VF in_order(VF v) {
    return hn::TableLookupLanes(v, hn::SetTableIndices(f, record_order.of.data()));
}

}  // namespace weft::light_field::WEFT_ISA
