#include <algorithm>
#include <cmath>

#include "light-field/simd.h"
#include "light-field/smooth_radiance_kernel.h"

namespace weft::light_field::WEFT_ISA {
namespace {

constexpr size_t widths = Smoothing::widths;

// work(i, distance, mask) for vectors i ... of neighbours of sample `at` within the widest kernel that lie on
// its surface.
template <class Work>
HWY_INLINE void each_neighbour(const SampleField& s, const Smoothing& by, size_t at, Work&& work) {
    const float reach = by.width[widths - 1];
    const VF x = hn::Set(f, s.x[at]), y = hn::Set(f, s.y[at]), limit = hn::Set(f, reach * reach);
    const VF slope = hn::Set(f, s.slope[at]), vx = hn::Set(f, s.velocity_x[at]), vy = hn::Set(f, s.velocity_y[at]);
    const VF depth = hn::Set(f, s.log_depth[at]);
    const VF slope_limit = hn::Set(f, by.slope), velocity_limit = hn::Set(f, by.velocity), depth_limit = hn::Set(f, by.depth);
    const int left = s.column_of(s.x[at] - reach), right = s.column_of(s.x[at] + reach);
    const int top = s.row_of(s.y[at] - reach), bottom = s.row_of(s.y[at] + reach);
    for (int row = top; row <= bottom; ++row) {
        const std::uint32_t* start = &s.start[size_t(row) * size_t(s.columns)];
        const size_t end = start[right + 1];
        for (size_t i = start[left]; i < end; i += lanes) {
            const VF dx = hn::Sub(hn::LoadU(f, &s.x[i]), x), dy = hn::Sub(hn::LoadU(f, &s.y[i]), y);
            const VF d2 = hn::MulAdd(dx, dx, hn::Mul(dy, dy));
            auto near = hn::And(hn::Lt(d2, limit), hn::FirstN(f, end - i));
            if (hn::AllFalse(f, near)) continue;
            near = hn::And(near, hn::Le(hn::AbsDiff(hn::LoadU(f, &s.slope[i]), slope), slope_limit));
            near = hn::And(near, hn::Le(hn::AbsDiff(hn::LoadU(f, &s.log_depth[i]), depth), depth_limit));
            near = hn::And(near, hn::Le(hn::AbsDiff(hn::LoadU(f, &s.velocity_x[i]), vx), velocity_limit));
            near = hn::And(near, hn::Le(hn::AbsDiff(hn::LoadU(f, &s.velocity_y[i]), vy), velocity_limit));
            work(i, hn::Sqrt(d2), near);
        }
    }
}

float sum(VF v) { return hn::GetLane(hn::SumOfLanes(f, v)); }

}  // namespace

void predict(const SampleField& s, const Smoothing& by, size_t begin, size_t end, Predictions& out) {
    const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f);
    for (size_t at = begin; at < end; ++at) {
        VF w[widths], r[widths], g[widths], b[widths];
        for (size_t k = 0; k < widths; ++k) w[k] = r[k] = g[k] = b[k] = zero;
        const VI self = hn::Set(sn, std::int32_t(at));
        each_neighbour(s, by, at, [&](size_t i, VF distance, auto near) {
            const auto other = hn::AndNot(hn::RebindMask(f, hn::Eq(hn::Iota(sn, std::int32_t(i)), self)), near);
            const VF ri = hn::LoadU(f, &s.r[i]), gi = hn::LoadU(f, &s.g[i]), bi = hn::LoadU(f, &s.b[i]);
            for (size_t k = 0; k < widths; ++k) {
                const VF tent = hn::Max(zero, hn::NegMulAdd(distance, hn::Set(f, 1.0f / by.width[k]), one));
                const VF weight = hn::IfThenElseZero(other, tent);
                w[k] = hn::Add(w[k], weight);
                r[k] = hn::MulAdd(weight, ri, r[k]);
                g[k] = hn::MulAdd(weight, gi, g[k]);
                b[k] = hn::MulAdd(weight, bi, b[k]);
            }
        });
        const float own[3] = {s.r[at], s.g[at], s.b[at]};
        float weight[widths], mean[widths][3];
        for (size_t k = 0; k < widths; ++k) {
            weight[k] = sum(w[k]);
            const float all[3] = {sum(r[k]), sum(g[k]), sum(b[k])};
            for (size_t c = 0; c < 3; ++c) mean[k][c] = all[c];
            out.r[at * widths + k] = (all[0] + own[0]) / (weight[k] + 1);
            out.g[at * widths + k] = (all[1] + own[1]) / (weight[k] + 1);
            out.b[at * widths + k] = (all[2] + own[2]) / (weight[k] + 1);
        }
        const size_t last = at * widths + widths - 1;
        const float wide[3] = {out.r[last], out.g[last], out.b[last]};
        for (size_t k = 0; k < widths; ++k) {
            float error = 0;
            for (size_t c = 0; c < 3; ++c) {
                const float guess = weight[k] > 0 ? mean[k][c] / weight[k] : wide[c], off = own[c] - guess;
                error += off * off / (wide[c] * wide[c] + by.epsilon * by.epsilon);
            }
            out.error[k * s.x.size() + at] = error;
        }
    }
}

void choose(const SampleField& s, const Smoothing& by, const Predictions& from, size_t begin, size_t end,
            std::vector<std::uint8_t>& best) {
    const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f), per_reach = hn::Set(f, 1.0f / by.width[widths - 1]);
    const size_t pitch = s.x.size();
    for (size_t at = begin; at < end; ++at) {
        VF mean[widths], spread[widths];
        for (size_t k = 0; k < widths; ++k) mean[k] = spread[k] = zero;
        each_neighbour(s, by, at, [&](size_t i, VF distance, auto near) {
            const VF weight = hn::IfThenElseZero(near, hn::NegMulAdd(distance, per_reach, one));
            const VF narrow = hn::LoadU(f, &from.error[i]);
            for (size_t k = 1; k < widths; ++k) {
                // Against the narrowest, so that what all widths have in common falls out.
                const VF gain = hn::Mul(weight, hn::Sub(hn::LoadU(f, &from.error[k * pitch + i]), narrow));
                mean[k] = hn::Add(mean[k], gain);
                spread[k] = hn::MulAdd(gain, gain, spread[k]);
            }
        });
        float least = 0;
        best[at] = 0;
        for (size_t k = 1; k < widths; ++k) {
            const float score = sum(mean[k]) + by.caution * std::sqrt(sum(spread[k]));
            if (score < least) {
                least = score;
                best[at] = std::uint8_t(k);
            }
        }
    }
}

}  // namespace weft::light_field::WEFT_ISA
