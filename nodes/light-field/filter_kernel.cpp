// Filters the visible surface: a tent around the location, raised to a power.
#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {
namespace {
using Q = hn::FixedTag<float, 4>;
constexpr Q q;

// Weights of n points; their sum. `whole`: the exponent, where it is a small whole number.
float weigh(const float* dx, const float* dy, size_t n, const Tent& tent, int whole, float* weight) {
    const VF per_radius = hn::Set(f, -1.0f / tent.radius), one = hn::Set(f, 1.0f), zero = hn::Zero(f);
    VF sum = zero;
    for (size_t i = 0; i < n; i += lanes) {
        const VF x = hn::LoadU(f, dx + i), y = hn::LoadU(f, dy + i);
        const VF distance = hn::Sqrt(hn::MulAdd(x, x, hn::Mul(y, y)));
        const VF inside = hn::Max(zero, hn::MulAdd(distance, per_radius, one));
        VF w = inside;
        for (int power = 1; power < whole; ++power) w = hn::Mul(w, inside);
        w = hn::IfThenElseZero(hn::FirstN(f, n - i), w);
        hn::StoreU(w, f, weight + i);
        sum = hn::Add(sum, w);
    }
    if (whole > 0) return hn::GetLane(hn::SumOfLanes(f, sum));
    float total = 0;
    for (size_t i = 0; i < n; ++i) {
        weight[i] = weight[i] > 0 ? std::pow(weight[i], tent.exponent) : 0.0f;
        total += weight[i];
    }
    return total;
}

void write_mean(const float* rgba, const std::uint32_t* sample, const float* weight, size_t n, float sum, float* out) {
    auto even = hn::Zero(q), odd = hn::Zero(q);
    size_t i = 0;
    for (; i + 1 < n; i += 2) {
        even = hn::MulAdd(hn::Set(q, weight[i]), hn::LoadU(q, rgba + 4 * size_t(sample[i])), even);
        odd = hn::MulAdd(hn::Set(q, weight[i + 1]), hn::LoadU(q, rgba + 4 * size_t(sample[i + 1])), odd);
    }
    if (i < n) even = hn::MulAdd(hn::Set(q, weight[i]), hn::LoadU(q, rgba + 4 * size_t(sample[i])), even);
    hn::StoreU(hn::Mul(hn::Add(even, odd), hn::Set(q, 1.0f / sum)), q, out);
}

}  // namespace

void filter(const Candidates& c, const Surfaces& s, const Visibility& visibility, const Tent& tent,
            FilterScratch& scratch, Colors& out) {
    const size_t n = c.size();
    const int whole = tent.exponent == std::floor(tent.exponent) && tent.exponent >= 1 && tent.exponent <= 16
                          ? int(tent.exponent) : 0;
    out.rgba.resize(4 * n);
    out.valid.resize(n);
    const float* rgba = c.hierarchy->rgba.data();
    out.color_space = &c.hierarchy->color_space;
    for (size_t l = 0; l < n; ++l) {
        const size_t first = c.offset[l], all = c.of(l);
        float* to = &out.rgba[4 * l];
        out.valid[l] = visibility.decision[l] != Decision::undecided && all > 0;
        if (!out.valid[l]) {
            std::fill(to, to + 4, 0.0f);
            continue;
        }
        if (scratch.weight.size() < all + lanes) {
            const size_t size = 2 * (all + lanes);
            scratch.dx.resize(size);
            scratch.dy.resize(size);
            scratch.weight.resize(size);
            scratch.sample.resize(size);
        }
        const float *dx = &c.dx[first], *dy = &c.dy[first];
        const std::uint32_t* sample = &c.sample[first];
        float* weight = scratch.weight.data();
        size_t seen = all;
        if (s.count_of[l] > 1) {
            seen = 0;
            for (size_t i = 0; i < all; ++i) {
                const std::uint16_t surface = s.surface[first + i];
                scratch.dx[seen] = dx[i];
                scratch.dy[seen] = dy[i];
                scratch.sample[seen] = sample[i];
                seen += surface >= visibility.first[l] && surface <= visibility.last[l];
            }
            dx = scratch.dx.data();
            dy = scratch.dy.data();
            sample = scratch.sample.data();
        }
        const float sum = weigh(dx, dy, seen, tent, whole, weight);
        if (sum > 0) {
            write_mean(rgba, sample, weight, seen, sum, to);
            continue;
        }
        size_t nearest = 0;
        float least = 1e38f;
        for (size_t i = 0; i < seen; ++i) {
            const float distance = dx[i] * dx[i] + dy[i] * dy[i];
            if (distance < least) {
                least = distance;
                nearest = i;
            }
        }
        std::copy_n(rgba + 4 * size_t(sample[nearest]), 4, to);
    }
}

}  // namespace weft::light_field::WEFT_ISA
