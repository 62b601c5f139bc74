// Finds the samples near each location.
#include <algorithm>
#include <cmath>

#include "light-field/grid_reach.h"
#include "light-field/group_test.h"
#include "light-field/kernels.h"
#include "light-field/path_vectors.h"
#include "light-field/projected_entries.h"

namespace weft::light_field::WEFT_ISA {
namespace {
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
    // A row's run of cells holds some 12 samples within the usual radius, so that many are looked at
    // without asking; what follows a run is farther away than the radius, or padding.
    constexpr size_t usual = Projection::padding;
    const size_t n = at.size(), pitch = size_t(p.columns) + 1;
    const VF limit = hn::Set(f, radius * radius);
    constexpr size_t at_once = 64;
    std::uint32_t cells[3][at_once];
    const Reach reach{cells[0], cells[1], cells[2]};
    size_t k = 0;
    for (size_t first = 0; first < n; first += at_once) {
        const size_t count = std::min(n - first, at_once);
        find_reach(p, &at.x[first], &at.y[first], count, radius, reach);
        for (size_t j = 0; j < count; ++j) {
            const size_t l = first + j;
            const std::uint32_t* row = p.start.data() + reach.first[j];
            const size_t across = reach.across[j], rows = reach.rows[j];
            size_t tested = rows * usual + lanes;
            for (size_t r = 0; r < rows; ++r) tested += row[r * pitch + across] - row[r * pitch];
            const Ends end = room(out, k, tested);
            const VF at_x = hn::Set(f, at.x[l]), at_y = hn::Set(f, at.y[l]);
            Spread spread;
            const size_t before = k;
            const auto look = [&](size_t i) HWY_ATTR {
                const EntryVectors entries(&p.entries[i]);
                const VF dx = hn::Sub(in_order(entries.x()), at_x),
                         dy = hn::Sub(in_order(entries.y()), at_y);
                const auto in = hn::Lt(hn::MulAdd(dx, dx, hn::Mul(dy, dy)), limit);
                const Pack pack(in);
                pack.store(dx, end.dx + k);
                pack.store(dy, end.dy + k);
                pack.store(in_order(entries.sample()), end.sample + k);
                k += pack.count;
                if constexpr (each) spread.add(in_order(entries.traits()), in);
            };
            for (size_t r = 0; r < rows; ++r, row += pitch) {
                size_t i = row[0];
                const size_t stop = row[across];
                for (size_t done = 0; done < usual; done += lanes, i += lanes) look(i);
                for (; i < stop; i += lanes) look(i);
            }
            out.offset[l + 1] = std::uint32_t(k);
            if constexpr (each) out.spread[l] = k > before ? spread.between() : 0;
            else out.spread[l] = p.spread;
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
    if (small) gather_all<false>(p, at, radius, out);
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
        const GroupTest test(h, u, v, d, at.x[l] - radius, at.x[l] + radius, at.y[l] - radius, at.y[l] + radius);
        VF low[3] = {huge, huge, huge}, high[3] = {tiny, tiny, tiny};
        const auto note = [&](int part, VF value, auto in) {
            low[part] = hn::Min(low[part], hn::IfThenElse(in, value, huge));
            high[part] = hn::Max(high[part], hn::IfThenElse(in, value, tiny));
        };
        for (size_t i = 0; i < block.groups; i += lanes) {
            for (unsigned hits = bits_of(f, test(block, i)); hits; hits &= hits - 1) {
                const size_t begin = size_t(block.group[i + size_t(__builtin_ctz(hits))]) * Hierarchy::group_size;
                const Ends end = room(out, k, Hierarchy::group_size + lanes);
                for (size_t j = begin; j < begin + Hierarchy::group_size; j += lanes) {
                    VF X = hn::LoadU(f, &h.X[j]), Y = hn::LoadU(f, &h.Y[j]), W = hn::LoadU(f, &h.W[j]);
                    VF VX = zero, VY = zero, VW = zero;
                    if (h.moving) {
                        const PathVectors path(&h.paths[4 * j]);
                        VX = path.VX, VY = path.VY, VW = path.VW;
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
                    pack.store(numbers_from(std::uint32_t(j)), end.sample + k);
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
