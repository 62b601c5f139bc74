// Vectors of the instruction set this file is compiled for, and packing of lanes. To be included by
// kernels only (weft_kernels); everything lives in the namespace of the instruction set.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <hwy/highway.h>

namespace weft::light_field::WEFT_ISA {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::ScalableTag<float>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using VU = hn::Vec<U>;
inline constexpr F f{};
inline constexpr I sn{};
inline constexpr U un{};
inline constexpr size_t lanes = hn::MaxLanes(F());
static_assert(lanes == 4 || lanes == 8 || lanes == 16);

// first, first + 1, ... (Highway's Iota stores lane by lane, and waits to load what it stored.)
struct LaneNumbers {
    alignas(64) std::array<std::uint32_t, lanes> of{};
    constexpr LaneNumbers() {
        for (unsigned lane = 0; lane < lanes; ++lane) of[lane] = lane;
    }
};
inline constexpr LaneNumbers lane_numbers;
HWY_INLINE VU numbers_from(std::uint32_t first) {
    return hn::Add(hn::Load(un, lane_numbers.of.data()), hn::Set(un, first));
}

// The true lanes of a mask, as bits.
template <class D, class M>
HWY_INLINE unsigned bits_of(D d, M mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    std::uint16_t bits;
    std::memcpy(&bits, bytes, 2);
    return bits & ((1u << lanes) - 1);
}

// Lane numbers, a byte each, that bring the lanes of a mask to the front. (Highway's own tables for 4 and
// 8 lanes are local arrays, which GCC 12 copies to the stack at every use.)
#if HWY_MAX_BYTES == 32
struct PackTable {
    alignas(64) std::array<std::uint64_t, 256> order{};
    constexpr PackTable() {
        for (unsigned bits = 0; bits < 256; ++bits) {
            unsigned to = 0;
            for (unsigned wanted : {1u, 0u})
                for (unsigned lane = 0; lane < 8; ++lane)
                    if ((bits >> lane & 1) == wanted) order[bits] |= std::uint64_t(lane) << (8 * to++);
        }
    }
};
inline constexpr PackTable pack_table;
#elif HWY_MAX_BYTES == 16
struct PackTable {
    alignas(64) std::array<std::array<std::uint8_t, 16>, 16> order{};
    constexpr PackTable() {
        for (unsigned bits = 0; bits < 16; ++bits) {
            unsigned to = 0;
            for (unsigned wanted : {1u, 0u})
                for (unsigned lane = 0; lane < 4; ++lane)
                    if ((bits >> lane & 1) == wanted)
                        for (unsigned byte = 0; byte < 4; ++byte) order[bits][to++] = std::uint8_t(4 * lane + byte);
        }
    }
};
inline constexpr PackTable pack_table;
#endif

// Brings the lanes of a mask to the front, in order; made once for a mask, used for several vectors.
class Pack {
  public:
    template <class M>
    HWY_INLINE explicit Pack(M mask) : mask_(hn::RebindMask(un, mask)) {
        const unsigned bits = bits_of(un, mask_);
        count = size_t(__builtin_popcount(bits));
#if HWY_MAX_BYTES == 32
        const hn::FixedTag<std::uint8_t, 8> bytes;
        order_ = hn::PromoteTo(un, hn::Load(bytes, reinterpret_cast<const std::uint8_t*>(&pack_table.order[bits])));
#elif HWY_MAX_BYTES == 16
        order_ = hn::BitCast(un, hn::Load(hn::Repartition<std::uint8_t, F>(), pack_table.order[bits].data()));
#endif
    }
    HWY_INLINE void store(VU v, std::uint32_t* to) const { hn::StoreU(packed(v), un, to); }
    HWY_INLINE void store(VF v, float* to) const { hn::StoreU(hn::BitCast(f, packed(hn::BitCast(un, v))), f, to); }

    size_t count;  // true lanes

  private:
    HWY_INLINE VU packed(VU v) const {
#if HWY_MAX_BYTES == 32
        return hn::TableLookupLanes(v, hn::IndicesFromVec(un, order_));
#elif HWY_MAX_BYTES == 16
        return hn::TableLookupBytes(v, order_);
#else
        return hn::Compress(v, mask_);
#endif
    }
    hn::Mask<U> mask_;
    VU order_ = hn::Zero(un);
};

// Which of the next lanes' surfaces are in [first, last].
HWY_INLINE hn::Mask<F> surface_among(const std::uint16_t* surfaces, std::uint16_t first, std::uint16_t last) {
    const VI surface = hn::PromoteTo(sn, hn::LoadU(hn::Rebind<std::uint16_t, I>(), surfaces));
    const auto outside = hn::Or(hn::Lt(surface, hn::Set(sn, first)), hn::Gt(surface, hn::Set(sn, last)));
    return hn::RebindMask(f, hn::Not(outside));
}

// The lowest of each of the four bytes over all lanes.
using B = hn::Repartition<std::uint8_t, F>;
inline constexpr B un8{};
HWY_INLINE std::uint32_t lowest_bytes(VU v) {
    const hn::FixedTag<std::uint32_t, 4> q;
    const hn::FixedTag<std::uint8_t, 16> qb;
#if HWY_MAX_BYTES == 64
    const hn::FixedTag<std::uint32_t, 8> o;
    const hn::FixedTag<std::uint8_t, 32> ob;
    const auto eight = hn::BitCast(o, hn::Min(hn::BitCast(ob, hn::LowerHalf(o, v)), hn::BitCast(ob, hn::UpperHalf(o, v))));
    auto low = hn::Min(hn::BitCast(qb, hn::LowerHalf(q, eight)), hn::BitCast(qb, hn::UpperHalf(q, eight)));
#elif HWY_MAX_BYTES == 32
    auto low = hn::Min(hn::BitCast(qb, hn::LowerHalf(q, v)), hn::BitCast(qb, hn::UpperHalf(q, v)));
#else
    auto low = hn::BitCast(qb, v);
#endif
    low = hn::Min(low, hn::BitCast(qb, hn::Shuffle1032(hn::BitCast(q, low))));
    low = hn::Min(low, hn::BitCast(qb, hn::Shuffle2301(hn::BitCast(q, low))));
    return hn::GetLane(hn::BitCast(q, low));
}

// Bytes that three quantities of a sample are rounded to, and how far they spread among samples:
// lowest of each and, of the complements, lowest again.
struct Spread {
    VU least = hn::Set(un, 0xffffffffu), most = hn::Set(un, 0xffffffffu);
    template <class M>
    HWY_INLINE void add(VU four, M in) {
        const VU outside = hn::VecFromMask(un, hn::Not(hn::RebindMask(un, in)));
        least = hn::BitCast(un, hn::Min(hn::BitCast(un8, least), hn::BitCast(un8, hn::Or(four, outside))));
        most = hn::BitCast(un, hn::Min(hn::BitCast(un8, most), hn::BitCast(un8, hn::Or(hn::Not(four), outside))));
    }
    // Highest minus lowest of each byte, all ones where a fourth byte was set: its sample's quantities do
    // not fit. Of something that at least one sample was added to.
    HWY_INLINE std::uint32_t between() const {
        const std::uint32_t high = ~lowest_bytes(most);
        return high >> 24 ? 0xffffffffu : high - lowest_bytes(least);
    }
};

}  // namespace weft::light_field::WEFT_ISA
