// Finds the samples near each location.
#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {
namespace {
using B = hn::Repartition<std::uint8_t, F>;
constexpr B by;

std::uint32_t bytes_lowest(VU a) {
    alignas(64) std::uint32_t values[16];
    hn::Store(a, un, values);
    const hn::FixedTag<std::uint32_t, 4> q;
    const hn::FixedTag<std::uint8_t, 16> qb;
    auto low = hn::BitCast(qb, hn::Load(q, values));
    for (size_t i = 4; i < lanes; i += 4) low = hn::Min(low, hn::BitCast(qb, hn::Load(q, values + i)));
    low = hn::Min(low, hn::BitCast(qb, hn::Shuffle1032(hn::BitCast(q, low))));
    low = hn::Min(low, hn::BitCast(qb, hn::Shuffle2301(hn::BitCast(q, low))));
    return hn::GetLane(hn::BitCast(q, low));
}

struct Ends {
    float* dx;
    float* dy;
    std::uint32_t* sample;
};

// Room for `more` candidates after the first k.
Ends room(Candidates& out, size_t k, size_t more) {
    if (out.dx.size() < k + more) {
        const size_t size = 2 * (k + more);
        out.dx.resize(size);
        out.dy.resize(size);
        out.sample.resize(size);
    }
    return {out.dx.data(), out.dy.data(), out.sample.data()};
}

void start(Candidates& out, const Locations& at, float radius) {
    const size_t n = at.size();
    out.radius = radius;
    out.offset.resize(n + 1);
    out.spread.resize(n);
    out.offset[0] = 0;
    out.x.assign(at.x.begin(), at.x.begin() + std::ptrdiff_t(n));
    out.y.assign(at.y.begin(), at.y.begin() + std::ptrdiff_t(n));
    const std::ptrdiff_t sets = at.shared ? std::ptrdiff_t(n > 0) : std::ptrdiff_t(n);
    out.u.assign(at.u.begin(), at.u.begin() + sets);
    out.v.assign(at.v.begin(), at.v.begin() + sets);
    out.t.assign(at.t.begin(), at.t.begin() + sets);
    out.shared = at.shared;
}

// `each`: the spread is taken location by location; else that of the whole projection stands for all.
template <bool each>
void gather_all(const Projection& p, const Locations& at, float radius, Candidates& out) {
    const size_t n = at.size(), pitch = size_t(p.columns) + 1;
    const float reach = radius * 1.00001f + 1e-5f;  // cells are chosen by rounded numbers
    const float per_width = 1 / p.cell_width, per_height = 1 / p.cell_height;
    const VF limit = hn::Set(f, radius * radius);
    const VU ones = hn::Set(un, 0xffffffffu);
    size_t k = 0;
    for (size_t l = 0; l < n; ++l) {
        const float x = at.x[l], y = at.y[l];
        const auto column_of = [&](float value) {
            return size_t(std::clamp(int(std::floor(value * per_width)) - p.column0, 0, p.columns - 1));
        };
        const auto row_of = [&](float value) {
            return size_t(std::clamp(int(std::floor(value * per_height)) - p.row0, 0, p.rows - 1));
        };
        const size_t left = column_of(x - reach), right = column_of(x + reach) + 1;
        const size_t top = row_of(y - reach), bottom = row_of(y + reach) + 1;
        const std::uint32_t* from = p.start.data() + top * pitch + left;
        const size_t across = right - left;
        size_t tested = 0;
        for (size_t row = 0; row < bottom - top; ++row) tested += from[row * pitch + across] - from[row * pitch] + lanes;
        const Ends end = room(out, k, tested + lanes);
        const VF at_x = hn::Set(f, x), at_y = hn::Set(f, y);
        VU least = ones, most = ones;  // `most` of the complements
        for (size_t row = top; row < bottom; ++row, from += pitch) {
            for (std::uint32_t i = from[0]; i < from[across]; i += std::uint32_t(lanes)) {
                const VF dx = hn::Sub(hn::LoadU(f, &p.x[i]), at_x), dy = hn::Sub(hn::LoadU(f, &p.y[i]), at_y);
                const auto in = hn::Lt(hn::MulAdd(dx, dx, hn::Mul(dy, dy)), limit);
                const Pack pack(in);
                pack.store(dx, end.dx + k);
                pack.store(dy, end.dy + k);
                pack.store(hn::LoadU(un, &p.sample[i]), end.sample + k);
                k += pack.count;
                if constexpr (each) {
                    const VU traits = hn::LoadU(un, &p.traits[i]), out_u = hn::VecFromMask(un, hn::RebindMask(un, hn::Not(in)));
                    least = hn::BitCast(un, hn::Min(hn::BitCast(by, least), hn::BitCast(by, hn::Or(traits, out_u))));
                    most = hn::BitCast(un, hn::Min(hn::BitCast(by, most),
                                                   hn::BitCast(by, hn::Or(hn::Xor(traits, ones), out_u))));
                }
            }
        }
        out.offset[l + 1] = std::uint32_t(k);
        if constexpr (each) {
            // Highest minus lowest of each byte: (255 - most) - least. No borrow where there is a candidate.
            const std::uint32_t low = bytes_lowest(least), high = ~bytes_lowest(most);
            out.spread[l] = k > out.offset[l] ? high - low : 0;
        } else {
            out.spread[l] = p.spread;
        }
    }
}

}  // namespace

void gather(const Projection& p, const Locations& at, float radius, Candidates& out) {
    out.hierarchy = p.hierarchy;
    start(out, at, radius);
    out.slope_step = p.slope_step;
    out.velocity_step = p.velocity_step;
    // Spreads that no test takes for two surfaces (half a pixel of slope, one of velocity) need not be
    // looked at more closely.
    const bool small = p.spread != 0xffffffffu && float((p.spread & 255) + 1) * p.slope_step < 0.5f &&
                       float((p.spread >> 8 & 255) + 1) * p.velocity_step < 1.0f &&
                       float((p.spread >> 16 & 255) + 1) * p.velocity_step < 1.0f;
    if (small || p.spread == 0xffffffffu) gather_all<false>(p, at, radius, out);
    else gather_all<true>(p, at, radius, out);
}

void gather_each(const Hierarchy& h, Block& block, const Locations& at, float radius, Candidates& out) {
    out.hierarchy = &h;
    start(out, at, radius);
    out.slope_step = 0.05f;
    out.velocity_step = 0.1f;
    const VF one = hn::Set(f, 1.0f), zero = hn::Zero(f), limit = hn::Set(f, radius * radius);
    const VF c0 = hn::Set(f, h.lens.c0), c1 = hn::Set(f, h.lens.c1);
    const VF huge = hn::Set(f, 1e30f), tiny = hn::Set(f, -1e30f);
    size_t k = 0;
    for (size_t l = 0; l < at.size(); ++l) {
        const float u = at.u_of(l), v = at.v_of(l), d = at.t_of(l) - 0.5f;
        const VF time = hn::Set(f, d), lens_x = hn::Set(f, u * h.lens.aspect), lens_y = hn::Set(f, v);
        const VF at_x = hn::Set(f, at.x[l]), at_y = hn::Set(f, at.y[l]);
        const VF left = hn::Set(f, at.x[l] - radius), right = hn::Set(f, at.x[l] + radius);
        const VF top = hn::Set(f, at.y[l] - radius), bottom = hn::Set(f, at.y[l] + radius);
        VF low[3] = {huge, huge, huge}, high[3] = {tiny, tiny, tiny};
        const auto note = [&](int part, VF value, auto in) {
            low[part] = hn::Min(low[part], hn::IfThenElse(in, value, huge));
            high[part] = hn::Max(high[part], hn::IfThenElse(in, value, tiny));
        };
        for (size_t i = 0; i < block.groups; i += lanes) {
            const VF slope = hn::LoadU(f, &block.slope[i]);
            const VF x = hn::MulAdd(slope, lens_x, hn::Mul(hn::LoadU(f, &block.velocity_x[i]), time));
            const VF y = hn::MulAdd(slope, lens_y, hn::Mul(hn::LoadU(f, &block.velocity_y[i]), time));
            const auto in_x = hn::And(hn::Le(hn::Add(hn::LoadU(f, &block.x_low[i]), x), right),
                                      hn::Ge(hn::Add(hn::LoadU(f, &block.x_high[i]), x), left));
            const auto in_y = hn::And(hn::Le(hn::Add(hn::LoadU(f, &block.y_low[i]), y), bottom),
                                      hn::Ge(hn::Add(hn::LoadU(f, &block.y_high[i]), y), top));
            for (unsigned hits = bits_of(f, hn::And(in_x, in_y)); hits; hits &= hits - 1) {
                const size_t begin = size_t(block.group[i + size_t(__builtin_ctz(hits))]) * Hierarchy::group_size;
                const Ends end = room(out, k, Hierarchy::group_size + lanes);
                for (size_t j = begin; j < begin + Hierarchy::group_size; j += lanes) {
                    VF X = hn::LoadU(f, &h.X[j]), Y = hn::LoadU(f, &h.Y[j]), W = hn::LoadU(f, &h.W[j]);
                    VF VX = zero, VY = zero, VW = zero;
                    if (h.moving) {
                        VX = hn::LoadU(f, &h.VX[j]);
                        VY = hn::LoadU(f, &h.VY[j]);
                        VW = hn::LoadU(f, &h.VW[j]);
                        X = hn::MulAdd(time, VX, X);
                        Y = hn::MulAdd(time, VY, Y);
                        W = hn::MulAdd(time, VW, W);
                    }
                    const VF inverse = hn::Div(one, W), c = hn::MulAdd(c0, inverse, c1);
                    const VF px = hn::MulAdd(c, lens_x, hn::Mul(X, inverse)), py = hn::MulAdd(c, lens_y, hn::Mul(Y, inverse));
                    const VF dx = hn::Sub(px, at_x), dy = hn::Sub(py, at_y);
                    const auto in = hn::And(hn::Lt(hn::MulAdd(dx, dx, hn::Mul(dy, dy)), limit), hn::Gt(W, zero));
                    const Pack pack(in);
                    pack.store(dx, end.dx + k);
                    pack.store(dy, end.dy + k);
                    pack.store(hn::Iota(un, std::uint32_t(j)), end.sample + k);
                    k += pack.count;
                    note(0, c, in);
                    note(1, hn::Mul(inverse, hn::NegMulAdd(VW, hn::NegMulAdd(c1, lens_x, px), VX)), in);
                    note(2, hn::Mul(inverse, hn::NegMulAdd(VW, hn::NegMulAdd(c1, lens_y, py), VY)), in);
                }
            }
        }
        room(out, k, lanes);
        out.offset[l + 1] = std::uint32_t(k);
        out.spread[l] = 0;
        for (int part = 0; part < 3 && k > out.offset[l]; ++part) {
            const float wide = hn::GetLane(hn::MaxOfLanes(f, high[part])) - hn::GetLane(hn::MinOfLanes(f, low[part]));
            const float steps = wide / (part == 0 ? out.slope_step : out.velocity_step);
            if (!(steps < 255)) {
                out.spread[l] = 0xffffffffu;
                break;
            }
            out.spread[l] |= std::uint32_t(steps) << (8 * part);
        }
    }
}

}  // namespace weft::light_field::WEFT_ISA
