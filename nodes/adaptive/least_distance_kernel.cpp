// Compiled once an instruction set. Loops are written for the compiler to make vectors of: no early
// exits, least values as whole numbers.
#include "adaptive/least_distance_kernel.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "filters/simd.h"

namespace weft::adaptive::WEFT_ISA {
namespace {

constexpr std::int32_t largest = std::numeric_limits<std::int32_t>::max();

struct Measured {
    std::int32_t within = 0;       // samples within reach
    std::int32_t least = largest;  // of all, by metric
};
// Fills both distances.
Measured measure(const NearSamples& near, float x, float y, float reach2, size_t n,
                 float* __restrict distance2, std::int32_t* __restrict by_metric) {
    const float *nx = near.x.data(), *ny = near.y.data(), *off2 = near.off2.data(),
                *xx = near.xx.data(), *xy = near.xy.data(), *yy = near.yy.data(),
                *bx = near.bx.data(), *by = near.by.data(), *rest = near.rest.data();
    std::int32_t within = 0, least = largest;
    for (size_t i = 0; i < n; ++i) {
        const float dx = x - nx[i], dy = y - ny[i];
        const float d2 = dx * dx + dy * dy + off2[i];
        float q =
            dx * (xx[i] * dx + 2 * (xy[i] * dy + bx[i])) + dy * (yy[i] * dy + 2 * by[i]) + rest[i];
        q = q > 0 ? q : 0;  // rounding
        distance2[i] = d2;
        const std::int32_t bits = std::bit_cast<std::int32_t>(q);
        by_metric[i] = bits;
        least = bits < least ? bits : least;
        within += d2 <= reach2 ? 1 : 0;
    }
    return {within, least};
}

}  // namespace

Nearest least_distances(const NearSamples& near, float x, float y, LeastDistance& scratch) {
    namespace hn = hwy::HWY_NAMESPACE;
    using kernel::WEFT_ISA::f;
    using kernel::WEFT_ISA::lanes;
    using kernel::WEFT_ISA::VF;
    const hn::RebindToSigned<hn::ScalableTag<float>> whole;
    const size_t n = (near.size + 15) / 16 * 16;
    if (scratch.distance2.size() < n) scratch.distance2.resize(n);
    float* by_metric = scratch.distance2.data();
    constexpr float none = std::numeric_limits<float>::infinity();
    const VF nowhere = hn::Set(f, none), at_x = hn::Set(f, x), at_y = hn::Set(f, y),
             two = hn::Set(f, 2.0f);
    VF least_of = nowhere;
    for (size_t i = 0; i < n; i += lanes) {
        const auto load = [&](const std::vector<float>& from) { return hn::LoadU(f, &from[i]); };
        const VF dx = hn::Sub(at_x, load(near.x)), dy = hn::Sub(at_y, load(near.y));
        const VF d2 = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, load(near.off2)));
        // xx dx^2 + 2 (xy dy + bx) dx, and yy dy^2 + 2 by dy + rest.
        const VF in_x = hn::MulAdd(load(near.xx), dx,
                                   hn::Mul(two, hn::MulAdd(load(near.xy), dy, load(near.bx))));
        const VF in_y = hn::MulAdd(load(near.yy), dy, hn::Mul(two, load(near.by)));
        const VF q = hn::Max(hn::MulAdd(in_x, dx, hn::MulAdd(in_y, dy, load(near.rest))),
                             hn::Zero(f));  // rounding
        const VF here = hn::IfThenElse(hn::Le(d2, load(near.support2)), q, nowhere);
        hn::StoreU(here, f, by_metric + i);
        least_of = hn::Min(least_of, here);
    }
    float least = hn::GetLane(hn::MinOfLanes(f, least_of));
    Nearest found;
    while (found.size < Nearest::most && least < none) {
        // Of several in one place the first alone.
        const VF at = hn::Set(f, least);
        auto winner = hn::Set(whole, largest);
        VF next = nowhere;
        for (size_t i = 0; i < n; i += lanes) {
            const VF here = hn::LoadU(f, by_metric + i);
            winner = hn::Min(
                winner, hn::IfThenElse(hn::RebindMask(whole, hn::Eq(here, at)),
                                       hn::Iota(whole, std::int32_t(i)), hn::Set(whole, largest)));
            next = hn::Min(next, hn::IfThenElse(hn::Gt(here, at), here, nowhere));
        }
        found.near[size_t(found.size)] = hn::GetLane(hn::MinOfLanes(whole, winner));
        found.distance2[size_t(found.size)] = least;
        ++found.size;
        least = hn::GetLane(hn::MinOfLanes(f, next));
    }
    return found;
}

void append_near(const SampleRun& run, size_t begin, size_t end, const float* sides,
                 const float* other, NearSamples& near) {
    namespace hn = hwy::HWY_NAMESPACE;
    const hn::RebindToUnsigned<hn::ScalableTag<float>> whole;
    const hn::RebindToSigned<hn::ScalableTag<float>> index;
    using kernel::WEFT_ISA::f;
    using kernel::WEFT_ISA::lanes;
    using kernel::WEFT_ISA::VF;
    const size_t axes = run.axes, numbers = axes * (axes + 1) / 2;
    const VF zero = hn::Zero(f);
    const auto beyond = [&](VF at, float lo, float hi) {
        return hn::Max(hn::Max(hn::Sub(hn::Set(f, lo), at), hn::Sub(at, hn::Set(f, hi))), zero);
    };
    for (size_t i = begin; i < end; i += lanes) {
        const size_t n = std::min(lanes, end - i);
        const auto there = hn::FirstN(f, n);
        const auto load = [&](const float* from) {
            if (n == lanes) return hn::LoadU(f, from);
            float tail[lanes] = {};
            std::copy_n(from, n, tail);
            return hn::LoadU(f, tail);
        };
        const VF x = load(run.at[0] + i), y = load(run.at[1] + i),
                 support2 = load(run.support2 + i);
        VF off[most_axes], off2 = zero;
        for (size_t d = 2; d < axes; ++d) {
            off[d] = hn::Sub(hn::Set(f, other[d]), load(run.at[d] + i));
            off2 = hn::MulAdd(off[d], off[d], off2);
        }
        const VF dx = beyond(x, sides[0], sides[2]), dy = beyond(y, sides[1], sides[3]);
        const auto inside =
            hn::And(there, hn::Le(hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, off2)), support2));
        if (hn::AllFalse(f, inside)) continue;
        const size_t room = near.size + 2 * lanes;
        if (near.support2.size() < room) {
            for (auto* values : {&near.x, &near.y, &near.off2, &near.xx, &near.xy, &near.yy,
                                 &near.bx, &near.by, &near.rest, &near.support2})
                values->resize(2 * room);
            near.place.resize(2 * room);
        }
        // Lanes past the end read the last sample's metric.
        const auto at = hn::Mul(hn::Min(hn::Iota(index, 0), hn::Set(index, std::int32_t(n) - 1)),
                                hn::Set(index, std::int32_t(numbers)));
        const float* first = run.upper + numbers * i;
        const auto entry = [&](size_t k) { return hn::GatherIndex(f, first + k, at); };
        VF bx = zero, by = zero, rest = zero;
        size_t k = 2 * axes - 1;  // of row 2, its diagonal
        for (size_t a = 2; a < axes; ++a) {
            bx = hn::MulAdd(entry(a), off[a], bx);
            by = hn::MulAdd(entry(axes + a - 1), off[a], by);
            VF row = hn::Mul(hn::Mul(hn::Set(f, 0.5f), entry(k++)), off[a]);
            for (size_t b = a + 1; b < axes; ++b) row = hn::MulAdd(entry(k++), off[b], row);
            rest = hn::MulAdd(hn::Add(row, row), off[a], rest);
        }
        const auto keep = [&](VF value, std::vector<float>& to) {
            hn::CompressStore(value, inside, f, &to[near.size]);
        };
        keep(x, near.x), keep(y, near.y), keep(off2, near.off2);
        keep(entry(0), near.xx), keep(entry(1), near.xy), keep(entry(axes), near.yy);
        keep(bx, near.bx), keep(by, near.by), keep(rest, near.rest);
        keep(support2, near.support2);
        near.size +=
            hn::CompressStore(hn::Iota(whole, std::uint32_t(i)), hn::RebindMask(whole, inside),
                              whole, &near.place[near.size]);
    }
}

// The sample of least distance by metric, of those nearer than `bound`; if it is not among the
// candidates, none that is as far off is one either, and so on.
std::int32_t least_distance(const NearSamples& near, float x, float y, std::int32_t candidates,
                            float reach2, LeastDistance& scratch) {
    const size_t n = near.x.size();
    if (scratch.distance2.size() < n) scratch.distance2.resize(n), scratch.by_metric.resize(n);
    float* __restrict distance2 = scratch.distance2.data();
    std::int32_t* __restrict by_metric = scratch.by_metric.data();
    const auto [within, of_all] = measure(near, x, y, reach2, n, distance2, by_metric);
    if (within < candidates) return not_known;
    float bound = std::numeric_limits<float>::infinity();
    for (std::int32_t least = of_all;;) {
        std::int32_t winner = largest;
        for (size_t i = 0; i < n; ++i) {
            const bool is = (by_metric[i] == least) & (distance2[i] < bound);
            const std::int32_t here = is ? std::int32_t(i) : largest;
            winner = here < winner ? here : winner;
        }
        if (winner == largest) return not_known;
        const float distance = distance2[winner];
        std::int32_t nearer = 0;
        for (size_t i = 0; i < n; ++i) nearer += distance2[i] < distance ? 1 : 0;
        if (nearer < candidates) return winner;
        bound = distance;
        least = largest;
        for (size_t i = 0; i < n; ++i) {
            const std::int32_t here = distance2[i] < bound ? by_metric[i] : largest;
            least = here < least ? here : least;
        }
    }
}

}  // namespace weft::adaptive::WEFT_ISA
