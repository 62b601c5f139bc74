// Vectors of the instruction set this file is compiled for. To be included by kernels only
// (weft_kernels).
#pragma once
#include <hwy/highway.h>

#include <cstddef>

namespace weft::kernel::WEFT_ISA {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::ScalableTag<float>;
using VF = hn::Vec<F>;
inline constexpr F f{};
inline constexpr size_t lanes = hn::MaxLanes(F());

inline constexpr size_t at_once = 4;  // vectors: as many sums as hide a multiply-add's latency

// `count` rounded up to whole vectors, or so many of them.
inline size_t whole_vectors(size_t count, size_t vectors = 1) {
    const size_t step = vectors * lanes;
    return (count + step - 1) / step * step;
}

// e^-x for x in [0, 87], to 2e-7 of itself: 2^n e^r with |r| <= ln 2 / 2, e^r by its Taylor series.
HWY_INLINE VF exp_of_minus(VF x) {
    const hn::RebindToSigned<F> whole;
    const auto n = hn::NearestInt(hn::Mul(x, hn::Set(f, -1.442695041f)));
    const VF k = hn::ConvertTo(f, n);
    // ln 2 in two parts, the first of which times n is exact.
    VF r = hn::NegMulAdd(k, hn::Set(f, 0.693359375f), hn::Neg(x));
    r = hn::NegMulAdd(k, hn::Set(f, -2.12194440e-4f), r);
    VF e = hn::Set(f, 1.0f / 720);
    for (const float term : {1.0f / 120, 1.0f / 24, 1.0f / 6, 1.0f / 2, 1.0f, 1.0f})
        e = hn::MulAdd(e, r, hn::Set(f, term));
    const auto power = hn::ShiftLeft<23>(hn::Add(n, hn::Set(whole, 127)));
    return hn::Mul(e, hn::BitCast(f, power));
}

}  // namespace weft::kernel::WEFT_ISA
