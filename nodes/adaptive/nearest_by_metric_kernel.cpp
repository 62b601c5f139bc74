// Compiled once an instruction set.
#include "adaptive/nearest_by_metric_kernel.h"

#include <algorithm>

#include "adaptive/store_some.h"
#include "adaptive/with_axes.h"
#include "filters/simd.h"

namespace weft::adaptive::WEFT_ISA {
namespace {
namespace hn = hwy::HWY_NAMESPACE;
using kernel::WEFT_ISA::f;
using kernel::WEFT_ISA::lanes;
using kernel::WEFT_ISA::VF;
const hn::RebindToUnsigned<hn::ScalableTag<float>> whole;
using VU = hn::Vec<decltype(whole)>;

template <int axes>
void find(const NearbySamples& nearby, const float* upper, const float* lo, const float* hi,
          CountingSamples& found) {
    constexpr size_t numbers = axes * (axes + 1) / 2, record = 1 + axes + numbers;
    std::vector<std::uint32_t>& which = found.place;
    which.resize(nearby.size + lanes);
    size_t kept = 0;
    for (size_t i = 0; i < nearby.size; i += lanes) {
        VF off2 = hn::Zero(f);
        for (int d = 0; d < axes; ++d) {
            const VF at = hn::LoadU(f, &nearby.at[size_t(d)][i]);
            const VF off =
                hn::Max(hn::Max(hn::Sub(hn::Set(f, lo[d]), at), hn::Sub(at, hn::Set(f, hi[d]))),
                        hn::Zero(f));
            off2 = hn::MulAdd(off, off, off2);
        }
        const auto counts = hn::Le(off2, hn::LoadU(f, &nearby.support2[i]));
        kept += store_some(hn::Iota(whole, std::uint32_t(i)), hn::RebindMask(whole, counts), whole,
                           &which[kept]);
    }
    which.resize(kept);
    found.records.resize(kept * record);
    float* to = found.records.data();
    for (std::uint32_t& w : which) {
        *to++ = nearby.support2[w];
        for (int d = 0; d < axes; ++d) *to++ = nearby.at[size_t(d)][w];
        w = nearby.place[w];
        const float* m = &upper[numbers * w];
        for (int a = 0; a < axes; ++a) {
            *to++ = *m++;
            for (int b = a + 1; b < axes; ++b) *to++ = 2 * *m++;
        }
    }
}

// One vector of places: distances ascend from `least[0]`, which is a register each.
template <int axes>
void nearest(const CountingSamples& samples, const Places& places, size_t first,
             NearestSamples& out) {
    constexpr size_t record = 1 + axes + axes * (axes + 1) / 2, most = NearestSamples::most;
    VF at[axes], least[most];
    VU which[most];
    for (int d = 0; d < axes; ++d) at[d] = hn::LoadU(f, &places.at[size_t(d)][first]);
    const VF none = hn::Set(f, NearestSamples::none);
    for (size_t k = 0; k < most; ++k) least[k] = none, which[k] = hn::Zero(whole);
    const float* r = samples.records.data();
    for (std::uint32_t i = 0; i < samples.place.size(); ++i, r += record) {
        VF off[axes], off2 = hn::Zero(f);
        for (int d = 0; d < axes; ++d) {
            off[d] = hn::Sub(at[d], hn::Set(f, r[1 + d]));
            off2 = hn::MulAdd(off[d], off[d], off2);
        }
        const auto counts = hn::Le(off2, hn::Set(f, r[0]));
        if (hn::AllFalse(f, counts)) continue;
        const float* m = r + 1 + axes;
        VF distance2 = hn::Zero(f);
        for (int a = 0; a < axes; ++a) {
            VF row = hn::Mul(hn::Set(f, *m++), off[a]);
            for (int b = a + 1; b < axes; ++b) row = hn::MulAdd(hn::Set(f, *m++), off[b], row);
            distance2 = hn::MulAdd(row, off[a], distance2);
        }
        distance2 = hn::IfThenElse(counts, hn::Max(distance2, hn::Zero(f)), none);  // rounding
        const auto in = hn::Lt(distance2, least[most - 1]);
        if (hn::AllFalse(f, in)) continue;
        // It takes the place of the first that is farther; those from there on move up.
        const VU self = hn::Set(whole, i);
        VF moving = distance2;
        VU moving_which = self;
        for (size_t k = 0; k < most; ++k) {
            const auto nearer = hn::Lt(moving, least[k]);
            const VF kept = least[k];
            const VU kept_which = which[k];
            least[k] = hn::IfThenElse(nearer, moving, kept);
            which[k] = hn::IfThenElse(hn::RebindMask(whole, nearer), moving_which, kept_which);
            moving = hn::IfThenElse(nearer, kept, moving);
            moving_which = hn::IfThenElse(hn::RebindMask(whole, nearer), kept_which, moving_which);
        }
    }
    for (size_t k = 0; k < most; ++k) {
        hn::StoreU(least[k], f, &out.distance2[k][first]);
        hn::StoreU(which[k], whole, &out.sample[k][first]);
    }
}

}  // namespace

void find_counting(const NearbySamples& nearby, const float* upper, const float* lo,
                   const float* hi, CountingSamples& found) {
    with_axes(nearby.axes, [&](auto n) { find<n.value>(nearby, upper, lo, hi, found); });
}

void nearest_by_metric(const CountingSamples& samples, const Places& places,
                       NearestSamples& nearest_samples) {
    const size_t padded = (places.size + 15) / 16 * 16;
    for (size_t k = 0; k < NearestSamples::most; ++k)
        if (nearest_samples.sample[k].size() < padded)
            nearest_samples.sample[k].resize(padded), nearest_samples.distance2[k].resize(padded);
    with_axes(places.axes, [&](auto n) {
        for (size_t first = 0; first < places.size; first += lanes)
            nearest<n.value>(samples, places, first, nearest_samples);
    });
}

}  // namespace weft::adaptive::WEFT_ISA
