#include <algorithm>
#include <cmath>

#include "light-field/simd.h"
#include "light-field/smooth_radiance_kernel.h"

namespace weft::light_field::WEFT_ISA {
namespace {

constexpr size_t widths = Smoothing::widths, treatments = Smoothing::treatments;

// work(i, distance, mask) for vectors i ... of neighbours of sample `at` within `reach` that lie on its surface.
template <class Work>
HWY_INLINE void each_neighbour(const SampleField& s, const Smoothing& by, float reach, size_t at, Work&& work) {
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
    const size_t pitch = s.x.size();
    for (size_t at = begin; at < end; ++at) {
        VF w[widths], r[widths], g[widths], b[widths];
        for (size_t k = 0; k < widths; ++k) w[k] = r[k] = g[k] = b[k] = zero;
        const VI self = hn::Set(sn, std::int32_t(at));
        each_neighbour(s, by, by.width[widths - 1], at, [&](size_t i, VF distance, auto near) {
            const auto other = hn::AndNot(hn::RebindMask(f, hn::Eq(hn::Iota(sn, std::int32_t(i)), self)), near);
            const VF ri = hn::LoadU(f, &s.r[i]), gi = hn::LoadU(f, &s.g[i]), bi = hn::LoadU(f, &s.b[i]);
            for (size_t k = 0; k < widths; ++k) {
                const VF tent = hn::Max(zero, hn::NegMulAdd(distance, hn::Set(f, 1.0f / by.width[k]), one));
                const VF weight = hn::IfThenElseZero(other, k == 0 ? hn::Mul(tent, tent) : tent);
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
            out.r[k * pitch + at] = (all[0] + own[0]) / (weight[k] + 1);
            out.g[k * pitch + at] = (all[1] + own[1]) / (weight[k] + 1);
            out.b[k * pitch + at] = (all[2] + own[2]) / (weight[k] + 1);
        }
        out.weight[at] = weight[0] + 1;
        const size_t last = (widths - 1) * pitch + at;
        const float wide[3] = {out.r[last], out.g[last], out.b[last]};
        for (size_t k = 0; k < widths; ++k) {
            float error = 0;
            for (size_t c = 0; c < 3; ++c) {
                const float guess = weight[k] > 0 ? mean[k][c] / weight[k] : wide[c], off = own[c] - guess;
                error += off * off / (wide[c] * wide[c] + by.epsilon * by.epsilon);
            }
            out.error[k * pitch + at] = error;
        }
    }
}

void sharpen(const SampleField& s, const Smoothing& by, size_t begin, size_t end, Predictions& out) {
    const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f), per_width = hn::Set(f, 1.0f / by.width[0]);
    const size_t pitch = s.x.size(), sharp = widths * pitch, wide = (widths - 1) * pitch;
    for (size_t at = begin; at < end; ++at) {
        VF r = zero, g = zero, b = zero, overlap = zero;
        each_neighbour(s, by, by.width[0], at, [&](size_t i, VF distance, auto near) {
            const VF tent = hn::NegMulAdd(distance, per_width, one), weight = hn::IfThenElseZero(near, hn::Mul(tent, tent));
            const auto doubled = [&](const std::vector<float>& y, const std::vector<float>& mean) {
                const VF value = hn::LoadU(f, &y[i]);
                return hn::Sub(hn::Add(value, value), hn::LoadU(f, &mean[i]));
            };
            r = hn::MulAdd(weight, doubled(s.r, out.r), r);
            g = hn::MulAdd(weight, doubled(s.g, out.g), g);
            b = hn::MulAdd(weight, doubled(s.b, out.b), b);
            overlap = hn::Add(overlap, hn::IfThenElseZero(near, hn::Div(hn::Mul(weight, weight), hn::LoadU(f, &out.weight[i]))));
        });
        // How much of the sample is in its own prediction: of H + H (1 - H), with H_ij = w_ij / W_i.
        const float own = (2 - sum(overlap)) / out.weight[at], left = std::max(1 - own, 1e-3f);
        const float y[3] = {s.r[at], s.g[at], s.b[at]}, guess[3] = {sum(r), sum(g), sum(b)};
        const float mean[3] = {out.r[wide + at], out.g[wide + at], out.b[wide + at]};
        float error = 0;
        for (size_t c = 0; c < 3; ++c) {
            const float off = (y[c] - guess[c] / out.weight[at]) / left;
            error += off * off / (mean[c] * mean[c] + by.epsilon * by.epsilon);
        }
        out.error[sharp + at] = own < 0.95f ? error : 1e6f;
        out.r[sharp + at] = std::max(0.0f, 2 * y[0] - out.r[at]);
        out.g[sharp + at] = std::max(0.0f, 2 * y[1] - out.g[at]);
        out.b[sharp + at] = std::max(0.0f, 2 * y[2] - out.b[at]);
    }
}

void choose(const SampleField& s, const Smoothing& by, const Predictions& from, size_t begin, size_t end,
            std::vector<std::uint8_t>& best) {
    const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f), per_reach = hn::Set(f, 1.0f / by.width[widths - 1]);
    const size_t pitch = s.x.size();
    for (size_t at = begin; at < end; ++at) {
        VF mean[treatments], spread[treatments];
        for (size_t k = 0; k < treatments; ++k) mean[k] = spread[k] = zero;
        each_neighbour(s, by, by.width[widths - 1], at, [&](size_t i, VF distance, auto near) {
            const VF weight = hn::IfThenElseZero(near, hn::NegMulAdd(distance, per_reach, one));
            const VF narrow = hn::LoadU(f, &from.error[i]);
            for (size_t k = 1; k < treatments; ++k) {
                // Against the sample as it is, so that what all have in common falls out.
                const VF gain = hn::Mul(weight, hn::Sub(hn::LoadU(f, &from.error[k * pitch + i]), narrow));
                mean[k] = hn::Add(mean[k], gain);
                spread[k] = hn::MulAdd(gain, gain, spread[k]);
            }
        });
        float least = 0;
        best[at] = 0;
        for (size_t k = 1; k < treatments; ++k) {
            const float caution = k == widths ? by.sharp_caution : by.caution;
            const float score = sum(mean[k]) + caution * std::sqrt(sum(spread[k]));
            if (score < least) {
                least = score;
                best[at] = std::uint8_t(k);
            }
        }
    }
}

}  // namespace weft::light_field::WEFT_ISA
