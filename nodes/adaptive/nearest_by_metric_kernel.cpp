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

constexpr size_t slice_record = 9;

// Of a sample `off` from the slice in the axes from 2 on; `m`: its metric.
template <int axes>
float* put_slice(float support2, float x, float y, const float* off, const float* m, float* to) {
    float bx = 0, by = 0, rest = 0;
    const float xx = *m++, xy = *m++;
    for (int a = 2; a < axes; ++a) bx += 2 * *m++ * off[a];
    const float yy = *m++;
    for (int a = 2; a < axes; ++a) by += 2 * *m++ * off[a];
    for (int a = 2; a < axes; ++a) {
        support2 -= off[a] * off[a];
        float row = *m++ * off[a];
        for (int b = a + 1; b < axes; ++b) row += 2 * *m++ * off[b];
        rest += row * off[a];
    }
    const float record[slice_record] = {support2, x, y, bx, xx, 2 * xy, by, yy, rest};
    return std::copy_n(record, slice_record, to);
}

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
    found.slice = axes > 2 && std::equal(lo + 2, lo + axes, hi + 2);
    found.records.resize(kept * (found.slice ? slice_record : record));
    float* to = found.records.data();
    for (std::uint32_t& w : which) {
        if (!found.slice) break;
        float off[axes];
        for (int d = 2; d < axes; ++d) off[d] = lo[d] - nearby.at[size_t(d)][w];
        const float support2 = nearby.support2[w], x = nearby.at[0][w], y = nearby.at[1][w];
        w = nearby.place[w];
        to = put_slice<axes>(support2, x, y, off, &upper[numbers * w], to);
    }
    if (found.slice) return;
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

// The nearest of one vector of places.
struct Nearest {
    static constexpr size_t most = NearestSamples::most;
    VF least[most];  // ascending distances, squared
    VU which[most];
    Nearest() {
        for (size_t k = 0; k < most; ++k)
            least[k] = hn::Set(f, NearestSamples::none), which[k] = hn::Zero(whole);
    }
    // Sample i, where it counts: it takes the place of the first that is farther; those from there
    // on move up.
    template <class M>
    HWY_INLINE void add(std::uint32_t i, VF distance2, M counts) {
        distance2 = hn::IfThenElse(counts, hn::Max(distance2, hn::Zero(f)),  // rounding
                                   hn::Set(f, NearestSamples::none));
        if (hn::AllFalse(f, hn::Lt(distance2, least[most - 1]))) return;
        VF moving = distance2;
        VU moving_which = hn::Set(whole, i);
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
    void store(size_t first, NearestSamples& out) const {
        for (size_t k = 0; k < most; ++k) {
            hn::StoreU(least[k], f, &out.distance2[k][first]);
            hn::StoreU(which[k], whole, &out.sample[k][first]);
        }
    }
};

template <int axes>
void nearest(const CountingSamples& samples, const Places& places, size_t first,
             NearestSamples& out) {
    constexpr size_t record = 1 + axes + axes * (axes + 1) / 2;
    VF at[axes];
    for (int d = 0; d < axes; ++d) at[d] = hn::LoadU(f, &places.at[size_t(d)][first]);
    Nearest found;
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
        found.add(i, distance2, counts);
    }
    found.store(first, out);
}

// The same in a slice.
void nearest_in_slice(const CountingSamples& samples, const Places& places, size_t first,
                      NearestSamples& out) {
    const VF x = hn::LoadU(f, &places.at[0][first]), y = hn::LoadU(f, &places.at[1][first]);
    Nearest found;
    const float* r = samples.records.data();
    for (std::uint32_t i = 0; i < samples.place.size(); ++i, r += slice_record) {
        const VF dx = hn::Sub(x, hn::Set(f, r[1])), dy = hn::Sub(y, hn::Set(f, r[2]));
        const auto counts = hn::Le(hn::MulAdd(dx, dx, hn::Mul(dy, dy)), hn::Set(f, r[0]));
        if (hn::AllFalse(f, counts)) continue;
        const VF along_x = hn::MulAdd(hn::Set(f, r[4]), dx, hn::Set(f, r[3])),
                 along_y = hn::MulAdd(hn::Set(f, r[7]), dy,
                                      hn::MulAdd(hn::Set(f, r[5]), dx, hn::Set(f, r[6])));
        found.add(i, hn::MulAdd(along_x, dx, hn::MulAdd(along_y, dy, hn::Set(f, r[8]))), counts);
    }
    found.store(first, out);
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
    for (size_t first = 0; samples.slice && first < places.size; first += lanes)
        nearest_in_slice(samples, places, first, nearest_samples);
    if (samples.slice) return;
    with_axes(places.axes, [&](auto n) {
        for (size_t first = 0; first < places.size; first += lanes)
            nearest<n.value>(samples, places, first, nearest_samples);
    });
}

}  // namespace weft::adaptive::WEFT_ISA
