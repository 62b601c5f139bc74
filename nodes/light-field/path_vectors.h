// How samples here and there move, as vectors. For kernels (weft_kernels).
#pragma once
#include "light-field/record_vectors.h"

namespace weft::light_field::WEFT_ISA {

// Samples of a list of `count`, a lane each; lanes past its end have its first.
HWY_INLINE VI samples_of(const std::uint32_t* list, size_t count) {
    return hn::BitCast(
        sn, hn::IfThenElse(hn::FirstN(un, count), hn::LoadU(un, list), hn::Set(un, list[0])));
}

// The divisors of samples' positions and the changes of all three (Hierarchy::paths), a lane a
// sample: those of `list`, of which there are `count`; lanes past them are its first. Four gathers
// would fetch the same four values of a sample one by one.
struct PathVectors {
    VF W, VX, VY, VW;

    // Those of samples that follow one another.
    HWY_INLINE explicit PathVectors(const float* paths) {
        const RecordVectors of(paths);
        W = in_order(of.first());
        VX = in_order(of.second());
        VY = in_order(of.third());
        VW = in_order(of.fourth());
    }

    HWY_INLINE PathVectors(const float* paths, const std::uint32_t* list, size_t count) {
        using Quad = hn::FixedTag<float, 4>;
        using Two = hn::Repartition<std::uint64_t, F>;
        constexpr Quad quad;
        constexpr Two two;
        // Every fourth sample, from the k-th on; then transposed within blocks of four.
        const auto part = [&](size_t k) HWY_ATTR {
            const auto one = [&](size_t lane) HWY_ATTR {
                return hn::LoadU(quad, paths + 4 * size_t(list[lane < count ? lane : 0]));
            };
#if HWY_MAX_BYTES == 64
            const hn::FixedTag<float, 8> eight;
            return hn::Combine(f, hn::Combine(eight, one(k + 12), one(k + 8)),
                               hn::Combine(eight, one(k + 4), one(k)));
#elif HWY_MAX_BYTES == 32
            return hn::Combine(f, one(k + 4), one(k));
#else
            return one(k);
#endif
        };
        const auto pair = [two](VF v) HWY_ATTR { return hn::BitCast(two, v); };
        const VF a = part(0), b = part(1), c = part(2), d = part(3);
        const auto low_ab = pair(hn::InterleaveLower(f, a, b)),
                   low_cd = pair(hn::InterleaveLower(f, c, d)),
                   high_ab = pair(hn::InterleaveUpper(f, a, b)),
                   high_cd = pair(hn::InterleaveUpper(f, c, d));
        const auto whole = [](auto v) HWY_ATTR { return hn::BitCast(f, v); };
        W = whole(hn::InterleaveLower(two, low_ab, low_cd));
        VX = whole(hn::InterleaveUpper(two, low_ab, low_cd));
        VY = whole(hn::InterleaveLower(two, high_ab, high_cd));
        VW = whole(hn::InterleaveUpper(two, high_ab, high_cd));
    }
};

}  // namespace weft::light_field::WEFT_ISA
