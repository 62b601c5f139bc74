// Weights of samples by distance, and weighted means of their colours (4 values a sample). For
// kernels (weft_kernels).
#pragma once
#include <algorithm>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {

using Q = hn::FixedTag<float, 4>;
inline constexpr Q q{};

// Weighted sums of colours that lie side by side, weights in the order of EntryVectors.
struct Sums {
    VF weight = hn::Zero(f), even = hn::Zero(f), odd = hn::Zero(f);

    HWY_INLINE void add(VF w, const float* rgba) {
        weight = hn::Add(weight, w);
        even = hn::MulAdd(hn::Broadcast<0>(w), hn::LoadU(f, rgba), even);
        odd = hn::MulAdd(hn::Broadcast<1>(w), hn::LoadU(f, rgba + lanes), odd);
        even = hn::MulAdd(hn::Broadcast<2>(w), hn::LoadU(f, rgba + 2 * lanes), even);
        odd = hn::MulAdd(hn::Broadcast<3>(w), hn::LoadU(f, rgba + 3 * lanes), odd);
    }
    // Writes the mean; returns the sum of weights. `opaque`: all alphas are 1, so that theirs is
    // it.
    HWY_INLINE float mean(bool opaque, float* out) const {
        const VF all = hn::Add(even, odd);
#if HWY_MAX_BYTES == 64
        const hn::FixedTag<float, 8> o;
        const auto half = hn::Add(hn::LowerHalf(o, all), hn::UpperHalf(o, all));
        const auto sum = hn::Add(hn::LowerHalf(q, half), hn::UpperHalf(q, half));
#elif HWY_MAX_BYTES == 32
        const auto sum = hn::Add(hn::LowerHalf(q, all), hn::UpperHalf(q, all));
#else
        const auto sum = all;
#endif
        const auto total =
            opaque ? hn::Broadcast<3>(sum) : hn::Set(q, hn::GetLane(hn::SumOfLanes(f, weight)));
        hn::StoreU(hn::Div(sum, total), q, out);
        return hn::GetLane(total);
    }
};

// (1 - d / radius)^power at squared distance d2, 0 past the radius.
template <int power>
struct TentWeight {
    VF per_radius;
    explicit TentWeight(float radius) : per_radius(hn::Set(f, 1.0f / radius)) {}
    HWY_INLINE VF operator()(VF d2) const {
        const VF inside =
            hn::Max(hn::Zero(f), hn::NegMulAdd(hn::Sqrt(d2), per_radius, hn::Set(f, 1.0f)));
        if constexpr (power == 1) return inside;
        const VF square = hn::Mul(inside, inside);
        if constexpr (power == 2) return square;
        return hn::Mul(square, square);
    }
};

HWY_INLINE VF squared(VF x, VF y) {
    return hn::MulAdd(x, x, hn::Mul(y, y));
}

// Weighted mean of n samples' colours, in the order in which they come; false where all weights
// vanish.
inline bool write_mean(const float* rgba, const std::uint32_t* sample, const float* weight,
                       size_t n, float* out) {
    auto even = hn::Zero(q), odd = hn::Zero(q), sums = hn::Zero(q);
    size_t i = 0;
    for (; i + 1 < n; i += 2) {
        const auto a = hn::Set(q, weight[i]), b = hn::Set(q, weight[i + 1]);
        even = hn::MulAdd(a, hn::LoadU(q, rgba + 4 * size_t(sample[i])), even);
        odd = hn::MulAdd(b, hn::LoadU(q, rgba + 4 * size_t(sample[i + 1])), odd);
        sums = hn::Add(sums, hn::Add(a, b));
    }
    if (i < n) {
        const auto a = hn::Set(q, weight[i]);
        even = hn::MulAdd(a, hn::LoadU(q, rgba + 4 * size_t(sample[i])), even);
        sums = hn::Add(sums, a);
    }
    hn::StoreU(hn::Div(hn::Add(even, odd), sums), q, out);
    return hn::GetLane(sums) > 0;
}

// Which of n samples is nearest, of equal ones the first.
inline size_t nearest(const float* dx, const float* dy, size_t n) {
    size_t nearest = 0;
    float least = 1e38f;
    for (size_t i = 0; i < n; ++i) {
        const float distance = dx[i] * dx[i] + dy[i] * dy[i];
        if (distance < least) {
            least = distance;
            nearest = i;
        }
    }
    return nearest;
}

inline void write_nearest(const float* rgba, const std::uint32_t* sample, const float* dx,
                          const float* dy, size_t n, float* out) {
    std::copy_n(rgba + 4 * size_t(sample[nearest(dx, dy, n)]), 4, out);
}

}  // namespace weft::light_field::WEFT_ISA
