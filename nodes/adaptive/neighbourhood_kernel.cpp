// Compiled once an instruction set.
#include "adaptive/neighbourhood_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "adaptive/store_some.h"
#include "adaptive/with_axes.h"
#include "filters/simd.h"

namespace weft::adaptive::WEFT_ISA {
namespace {
namespace hn = hwy::HWY_NAMESPACE;
using kernel::WEFT_ISA::exp_of_minus;
using kernel::WEFT_ISA::f;
using kernel::WEFT_ISA::lanes;
using kernel::WEFT_ISA::VF;
using kernel::WEFT_ISA::whole_vectors;

constexpr float nowhere = std::numeric_limits<float>::infinity();

// Squared distances of all around to the centre; by the metric, nowhere beyond `within2`. The
// largest that is somewhere.
template <int axes, bool by_metric>
float measure(const SamplesAround& around, const float* centre, const float* upper, float within2,
              float* distance2) {
    const size_t n = whole_vectors(around.size);
    VF farthest = hn::Zero(f);
    const VF limit = hn::Set(f, within2), none = hn::Set(f, nowhere);
    for (size_t i = 0; i < n; i += lanes) {
        VF d[axes], sum = hn::Zero(f);
        for (int a = 0; a < axes; ++a) {
            d[a] = hn::Sub(hn::LoadU(f, &around.at[size_t(a)][i]), hn::Set(f, centre[a]));
            sum = hn::MulAdd(d[a], d[a], sum);
        }
        const auto inside = hn::Le(sum, limit);
        if constexpr (by_metric) {
            const float* m = upper;
            sum = hn::Zero(f);
            for (int a = 0; a < axes; ++a) {
                const float own = *m++;
                VF row = hn::Zero(f);
                for (int b = a + 1; b < axes; ++b) row = hn::MulAdd(hn::Set(f, *m++), d[b], row);
                row = hn::MulAdd(hn::Set(f, own), d[a], hn::Add(row, row));
                sum = hn::MulAdd(row, d[a], sum);
            }
            sum = hn::Max(sum, hn::Zero(f));  // rounding
        }
        farthest = hn::Max(farthest, hn::IfThenElseZero(inside, sum));
        hn::StoreU(hn::IfThenElse(inside, sum, none), f, distance2 + i);
    }
    return hn::GetLane(hn::MaxOfLanes(f, farthest));
}

size_t count_within(const float* distance2, size_t n, float radius2) {
    const VF r = hn::Set(f, radius2);
    size_t count = 0;
    for (size_t i = 0; i < n; i += lanes)
        count += hn::CountTrue(f, hn::Le(hn::LoadU(f, distance2 + i), r));
    return count;
}

// A radius with at least `count` within, and hardly more: by how numbers grow with the radius.
float radius_for(const float* distance2, size_t n, size_t count, float most, size_t of_most,
                 float guess, float power) {
    const size_t enough = count + count / 8 + 1;
    if (of_most <= enough) return most;
    float lo = 0, hi = most;
    size_t below = 0, above = of_most;
    float at =
        guess > 0 && guess < most ? guess : most * std::pow(float(count) / float(of_most), power);
    for (int step = 0; step < 24 && hi > lo; ++step) {
        const size_t here = count_within(distance2, n, at);
        if (here >= count) {
            hi = at, above = here;
            if (here <= enough) break;
        } else {
            lo = at, below = here;
        }
        const float wanted = float(count) + 0.0625f * float(count);
        at = step > 6        ? 0.5f * (lo + hi)
             : here >= count ? hi * std::pow(wanted / float(above), power)
             : below > 0     ? lo * std::pow(wanted / float(below), power)
                             : 0.5f * (lo + hi);
        if (!(at > lo && at < hi)) at = 0.5f * (lo + hi);
        if (!(at > lo && at < hi)) break;
    }
    return hi;
}

template <int axes>
bool find(const SamplesAround& around, const float* centre, const float* upper, float within2,
          size_t count, Neighbourhood& found) {
    const size_t n = whole_vectors(around.size);
    if (found.distance2.size() < n) found.distance2.resize(n), found.near.resize(n + lanes);
    float* distance2 = found.distance2.data();
    const float most = upper ? measure<axes, true>(around, centre, upper, within2, distance2)
                             : measure<axes, false>(around, centre, upper, within2, distance2);
    const size_t all = count_within(distance2, n, most);
    found.near.resize(n + lanes);
    if (all < count) return false;
    found.guess = found.radius2 =
        radius_for(distance2, n, count, most, all, found.guess, 2.0f / float(axes));
    // Their indices, and the largest distance among them.
    const hn::RebindToUnsigned<hn::ScalableTag<float>> whole;
    const VF r = hn::Set(f, found.radius2);
    VF farthest = hn::Zero(f);
    size_t kept = 0;
    for (size_t i = 0; i < n; i += lanes) {
        const VF d = hn::LoadU(f, distance2 + i);
        const auto inside = hn::Le(d, r);
        farthest = hn::Max(farthest, hn::IfThenElseZero(inside, d));
        kept += store_some(hn::Iota(whole, std::uint32_t(i)), hn::RebindMask(whole, inside), whole,
                           &found.near[kept]);
    }
    found.near.resize(kept);
    found.radius2 = hn::GetLane(hn::MaxOfLanes(f, farthest));
    const size_t padded = whole_vectors(kept);
    found.weight.assign(padded, 0.0f);
    const float per = found.radius2 > 0 ? 2 / found.radius2 : 0;
    for (size_t k = 0; k < kept; ++k) found.weight[k] = per * distance2[found.near[k]];
    for (size_t k = 0; k < padded; k += lanes)
        hn::StoreU(exp_of_minus(hn::LoadU(f, &found.weight[k])), f, &found.weight[k]);
    std::fill(found.weight.begin() + std::ptrdiff_t(kept), found.weight.end(), 0.0f);
    return true;
}

template <int axes>
NeighbourSums sum(const SamplesAround& around, const float* centre,
                  const std::array<const float*, 3>& rgb, std::uint32_t self, Neighbourhood& of) {
    const size_t kept = of.near.size(), n = whole_vectors(kept);
    of.offset.assign(axes * n, 0.0f);
    of.change.assign(3 * n, 0.0f);
    NeighbourSums sums;
    for (size_t c = 0; c < 3; ++c) sums.least[c] = sums.most[c] = rgb[c][self];
    for (size_t k = 0; k < kept; ++k) {
        const std::uint32_t i = of.near[k], place = around.place[i];
        for (size_t a = 0; a < axes; ++a) of.offset[a * n + k] = around.at[a][i] - centre[a];
        for (size_t c = 0; c < 3; ++c) {
            const float value = rgb[c][place];
            of.change[c * n + k] = value - rgb[c][self];
            sums.least[c] = std::min(sums.least[c], value);
            sums.most[c] = std::max(sums.most[c], value);
        }
    }
    VF w = hn::Zero(f), sd[axes], sf[3], dd[axes * (axes + 1) / 2], df[3 * axes];
    for (VF& v : sd) v = hn::Zero(f);
    for (VF& v : sf) v = hn::Zero(f);
    for (VF& v : dd) v = hn::Zero(f);
    for (VF& v : df) v = hn::Zero(f);
    for (size_t k = 0; k < n; k += lanes) {
        const VF weight = hn::LoadU(f, &of.weight[k]);
        VF d[axes], change[3];
        for (size_t a = 0; a < axes; ++a) d[a] = hn::LoadU(f, &of.offset[a * n + k]);
        for (size_t c = 0; c < 3; ++c) change[c] = hn::LoadU(f, &of.change[c * n + k]);
        w = hn::Add(w, weight);
        for (size_t c = 0; c < 3; ++c) sf[c] = hn::MulAdd(weight, change[c], sf[c]);
        size_t at = 0;
        for (size_t a = 0; a < axes; ++a) {
            const VF wd = hn::Mul(weight, d[a]);
            sd[a] = hn::Add(sd[a], wd);
            for (size_t b = a; b < axes; ++b, ++at) dd[at] = hn::MulAdd(wd, d[b], dd[at]);
            for (size_t c = 0; c < 3; ++c)
                df[c * axes + a] = hn::MulAdd(wd, change[c], df[c * axes + a]);
        }
    }
    const auto all = [](VF v) { return hn::GetLane(hn::SumOfLanes(f, v)); };
    sums.w = all(w);
    for (size_t a = 0; a < axes; ++a) sums.d[a] = all(sd[a]);
    for (size_t c = 0; c < 3; ++c) sums.f[c] = all(sf[c]);
    for (size_t i = 0; i < axes * (axes + 1) / 2; ++i) sums.dd[i] = all(dd[i]);
    for (size_t i = 0; i < 3 * axes; ++i) sums.df[i] = all(df[i]);
    return sums;
}

template <int axes>
void append(const std::array<const float*, most_axes>& at, const std::uint32_t* place, size_t begin,
            size_t end, const float* lo, const float* hi, float reach2, SamplesAround& to) {
    const hn::RebindToUnsigned<hn::ScalableTag<float>> whole;
    const size_t room = whole_vectors(to.size + (end - begin) + lanes + 15);
    if (to.place.size() < room) {
        for (size_t a = 0; a < axes; ++a) to.at[a].resize(2 * room);
        to.place.resize(2 * room);
    }
    const float* from[axes];
    float* kept[axes];
    VF least[axes], most[axes];
    for (size_t a = 0; a < axes; ++a) {
        from[a] = at[a], kept[a] = to.at[a].data();
        least[a] = hn::Set(f, lo[a]), most[a] = hn::Set(f, hi[a]);
    }
    std::uint32_t* kept_place = to.place.data();
    size_t size = to.size;
    const VF limit = hn::Set(f, reach2);
    for (size_t i = begin; i < end; i += lanes) {
        const size_t n = std::min(lanes, end - i);
        const auto load = [&](const auto* values, auto d) {
            if (n == lanes) return hn::LoadU(d, values + i);
            hn::TFromD<decltype(d)> tail[lanes] = {};
            std::copy_n(values + i, n, tail);
            return hn::LoadU(d, tail);
        };
        VF x[axes], off2 = hn::Zero(f);
        for (size_t a = 0; a < axes; ++a) {
            x[a] = load(from[a], f);
            const VF off =
                hn::Max(hn::Max(hn::Sub(least[a], x[a]), hn::Sub(x[a], most[a])), hn::Zero(f));
            off2 = hn::MulAdd(off, off, off2);
        }
        const auto inside = hn::And(hn::FirstN(f, n), hn::Le(off2, limit));
        if (hn::AllFalse(f, inside)) continue;
        for (size_t a = 0; a < axes; ++a) store_some(x[a], inside, f, kept[a] + size);
        const auto which = place ? load(place, whole) : hn::Iota(whole, std::uint32_t(i));
        size += store_some(which, hn::RebindMask(whole, inside), whole, kept_place + size);
    }
    to.size = size;
    for (size_t a = 0; a < axes; ++a) std::fill_n(kept[a] + size, 16, 1e18f);
}

template <int axes>
void mean(const SamplesAround& around, const float* values, const Neighbourhood& of, float* to) {
    const hn::CappedTag<float, 8> part;
    constexpr size_t width = hn::MaxLanes(part), parts = averaged_stride(axes) / width;
    hn::Vec<decltype(part)> sum[parts];
    for (auto& s : sum) s = hn::Zero(part);
    float all = 0;
    for (size_t k = 0; k < of.near.size(); ++k) {
        const float* from = values + averaged_stride(axes) * around.place[of.near[k]];
        const auto weight = hn::Set(part, of.weight[k]);
        all += of.weight[k];
        for (size_t p = 0; p < parts; ++p)
            sum[p] = hn::MulAdd(weight, hn::LoadU(part, from + p * width), sum[p]);
    }
    float sums[averaged_stride(axes)];
    for (size_t p = 0; p < parts; ++p) hn::StoreU(sum[p], part, sums + p * width);
    for (size_t i = 0; i < averaged_numbers(axes); ++i) to[i] = sums[i] / all;
}

}  // namespace

bool find_neighbours(const SamplesAround& around, size_t axes, const float* centre,
                     const float* upper, float within2, size_t count, Neighbourhood& found) {
    return with_axes(
        axes, [&](auto n) { return find<n.value>(around, centre, upper, within2, count, found); });
}

NeighbourSums sum_neighbours(const SamplesAround& around, size_t axes, const float* centre,
                             const std::array<const float*, 3>& rgb, std::uint32_t self,
                             Neighbourhood& of) {
    return with_axes(axes, [&](auto n) { return sum<n.value>(around, centre, rgb, self, of); });
}

void append_within(const std::array<const float*, most_axes>& at, const std::uint32_t* place,
                   size_t begin, size_t end, size_t axes, const float* lo, const float* hi,
                   float reach2, SamplesAround& to) {
    with_axes(axes, [&](auto n) { append<n.value>(at, place, begin, end, lo, hi, reach2, to); });
}

void mean_of_neighbours(const SamplesAround& around, const float* values, size_t axes,
                        const Neighbourhood& of, float* to) {
    with_axes(axes, [&](auto n) { mean<n.value>(around, values, of, to); });
}

}  // namespace weft::adaptive::WEFT_ISA
