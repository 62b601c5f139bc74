// Filters the visible surface: a tent around the location, raised to a power.
#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/simd.h"
#include "light-field/weighted_mean.h"

namespace weft::light_field::WEFT_ISA {
namespace {
// Weights of n points. `power`: the exponent, where it is a small whole number; 0: any.
template <int power>
void weigh(const float* dx, const float* dy, size_t n, const Tent& tent, float* weight) {
    const VF per_radius = hn::Set(f, 1.0f / tent.radius), one = hn::Set(f, 1.0f), zero = hn::Zero(f);
    for (size_t i = 0; i < n; i += lanes) {
        const VF x = hn::LoadU(f, dx + i), y = hn::LoadU(f, dy + i);
        const VF distance = hn::Sqrt(hn::MulAdd(x, x, hn::Mul(y, y)));
        const VF inside = hn::Max(zero, hn::NegMulAdd(distance, per_radius, one));
        if constexpr (power == 2) hn::StoreU(hn::Mul(inside, inside), f, weight + i);
        else if constexpr (power == 4) hn::StoreU(hn::Mul(hn::Mul(inside, inside), hn::Mul(inside, inside)), f, weight + i);
        else hn::StoreU(inside, f, weight + i);
    }
    if constexpr (power == 0)
        for (size_t i = 0; i < n; ++i) weight[i] = weight[i] > 0 ? std::pow(weight[i], tent.exponent) : 0.0f;
}

// The candidates of surfaces [first, last], side by side in the scratch; their number.
size_t pick(const Candidates& c, const Surfaces& s, size_t l, std::uint16_t first, std::uint16_t last, FilterScratch& scratch) {
    size_t seen = 0;
    for (size_t i = c.offset[l], end = c.offset[l + 1]; i < end; i += lanes) {
        const Pack pack(hn::And(surface_among(&s.surface[i], first, last), hn::FirstN(f, end - i)));
        pack.store(hn::LoadU(f, &c.dx[i]), &scratch.dx[seen]);
        pack.store(hn::LoadU(f, &c.dy[i]), &scratch.dy[seen]);
        pack.store(hn::LoadU(un, &c.sample[i]), &scratch.sample[seen]);
        seen += pack.count;
    }
    return seen;
}

void grow(FilterScratch& scratch, size_t n) {
    if (scratch.weight.size() >= n) return;
    scratch.dx.resize(2 * n);
    scratch.dy.resize(2 * n);
    scratch.weight.resize(2 * n);
    scratch.sample.resize(2 * n);
}

// The mean of what location l sees of surfaces [first, last]; false where there is nothing.
template <int power>
bool filter_one(const Candidates& c, const Surfaces& s, size_t l, std::uint16_t first, std::uint16_t last, const Tent& tent,
                FilterScratch& scratch, float* to) {
    const float *rgba = c.hierarchy->rgba.data(), *dx = &c.dx[c.offset[l]], *dy = &c.dy[c.offset[l]];
    const std::uint32_t* sample = &c.sample[c.offset[l]];
    size_t seen = c.of(l);
    if (s.count_of[l] > 1) {
        seen = pick(c, s, l, first, last, scratch);
        dx = scratch.dx.data();
        dy = scratch.dy.data();
        sample = scratch.sample.data();
    }
    if (seen == 0) return false;
    weigh<power>(dx, dy, seen, {tent.radius * c.ratio_of(l), tent.exponent}, scratch.weight.data());
    if (!write_mean(rgba, sample, scratch.weight.data(), seen, to)) write_nearest(rgba, sample, dx, dy, seen, to);
    return true;
}

template <int power>
void filter_all(const Candidates& c, const Surfaces& s, const Visibility& visibility, const Tent& tent,
                FilterScratch& scratch, Colors& out) {
    size_t part = 0;
    for (size_t l = 0, n = c.size(); l < n; ++l) {
        float* to = &out.rgba[4 * l];
        std::fill(to, to + 4, 0.0f);
        out.valid[l] = 0;
        if (visibility.decision[l] == Decision::undecided || c.of(l) == 0) continue;
        grow(scratch, c.of(l) + 2 * lanes);
        if (visibility.decision[l] != Decision::partly) {
            out.valid[l] = filter_one<power>(c, s, l, visibility.first[l], visibility.last[l], tent, scratch, to);
            continue;
        }
        visibility.each_seen(l, part, [&](std::uint16_t first, std::uint16_t last, float share) {
            float mean[4];
            if (!filter_one<power>(c, s, l, first, last, tent, scratch, mean)) return;
            for (size_t k = 0; k < 4; ++k) to[k] += share * mean[k];
            out.valid[l] = 1;
        });
    }
}

}  // namespace

void filter(const Candidates& c, const Surfaces& s, const Visibility& visibility, const Tent& tent,
            FilterScratch& scratch, Colors& out) {
    const size_t n = c.size();
    out.rgba.resize(4 * n);
    out.valid.resize(n);
    out.color_space = &c.hierarchy->color_space;
    if (tent.exponent == 1) filter_all<1>(c, s, visibility, tent, scratch, out);
    else if (tent.exponent == 2) filter_all<2>(c, s, visibility, tent, scratch, out);
    else if (tent.exponent == 4) filter_all<4>(c, s, visibility, tent, scratch, out);
    else filter_all<0>(c, s, visibility, tent, scratch, out);
}

}  // namespace weft::light_field::WEFT_ISA
