// Carries a block's samples to one (u, v, t) and sorts them into a grid.
#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {
namespace {

// The groups whose bounds at (u, v, t) touch the grid.
size_t find_groups(const Hierarchy& h, Block& block, float u, float v, float d, float x0, float x1, float y0,
                   float y1) {
    const VF lens_x = hn::Set(f, u * h.lens.aspect), lens_y = hn::Set(f, v), time = hn::Set(f, d);
    const VF left = hn::Set(f, x0), right = hn::Set(f, x1), top = hn::Set(f, y0), bottom = hn::Set(f, y1);
    size_t found = 0;
    for (size_t i = 0; i < block.groups; i += lanes) {
        const VF slope = hn::LoadU(f, &block.slope[i]);
        const VF x = hn::MulAdd(slope, lens_x, hn::Mul(hn::LoadU(f, &block.velocity_x[i]), time));
        const VF y = hn::MulAdd(slope, lens_y, hn::Mul(hn::LoadU(f, &block.velocity_y[i]), time));
        const auto in_x = hn::And(hn::Le(hn::Add(hn::LoadU(f, &block.x_low[i]), x), right),
                                  hn::Ge(hn::Add(hn::LoadU(f, &block.x_high[i]), x), left));
        const auto in_y = hn::And(hn::Le(hn::Add(hn::LoadU(f, &block.y_low[i]), y), bottom),
                                  hn::Ge(hn::Add(hn::LoadU(f, &block.y_high[i]), y), top));
        const Pack pack(hn::And(in_x, in_y));
        pack.store(hn::LoadU(un, &block.group[i]), &block.seen[found]);
        found += pack.count;
    }
    return found;
}

// A byte of the traits, as a float that may lie outside [0, 255].
struct Quantity {
    VF low, scale;
    Quantity(float from, float step) : low(hn::Set(f, from)), scale(hn::Set(f, 1.0f / step)) {}
    VF operator()(VF value) const { return hn::Mul(hn::Sub(value, low), scale); }
};

template <bool moving>
void project_groups(const Hierarchy& h, Block& block, size_t groups, float u, float v, float d, Projection& out) {
    const VF one = hn::Set(f, 1.0f), zero = hn::Zero(f);
    const VF c0 = hn::Set(f, h.lens.c0), c1 = hn::Set(f, h.lens.c1), time = hn::Set(f, d);
    const VF lens_x = hn::Set(f, u * h.lens.aspect), lens_y = hn::Set(f, v);
    const VF own_x = hn::Set(f, h.lens.c1 * u * h.lens.aspect), own_y = hn::Set(f, h.lens.c1 * v);
    const VF per_width = hn::Set(f, 1.0f / out.cell_width), per_height = hn::Set(f, 1.0f / out.cell_height);
    const VI column0 = hn::Set(sn, out.column0), row0 = hn::Set(sn, out.row0), none = hn::Set(sn, -1);
    const VI columns = hn::Set(sn, out.columns), rows = hn::Set(sn, out.rows), pitch = hn::Set(sn, out.columns + 1);
    const Quantity slope_byte(block.slope_low, block.slope_step);
    const Quantity vx_byte(block.velocity_x_low, block.velocity_step), vy_byte(block.velocity_y_low, block.velocity_step);
    const VF most = hn::Set(f, 255.0f);
    VF lowest[3] = {hn::Set(f, 1e9f), hn::Set(f, 1e9f), hn::Set(f, 1e9f)};
    VF highest[3] = {hn::Set(f, -1e9f), hn::Set(f, -1e9f), hn::Set(f, -1e9f)};
    size_t n = 0;
    for (size_t k = 0; k < groups; ++k) {
        const size_t begin = size_t(block.seen[k]) * Hierarchy::group_size;
        for (size_t i = begin; i < begin + Hierarchy::group_size; i += lanes) {
            VF X = hn::LoadU(f, &h.X[i]), Y = hn::LoadU(f, &h.Y[i]), W = hn::LoadU(f, &h.W[i]);
            VF VX = zero, VY = zero, VW = zero;
            if constexpr (moving) {
                VX = hn::LoadU(f, &h.VX[i]);
                VY = hn::LoadU(f, &h.VY[i]);
                VW = hn::LoadU(f, &h.VW[i]);
                X = hn::MulAdd(time, VX, X);
                Y = hn::MulAdd(time, VY, Y);
                W = hn::MulAdd(time, VW, W);
            }
            const VF inverse = hn::Div(one, W);
            const VF slope = hn::MulAdd(c0, inverse, c1);
            const VF x = hn::MulAdd(slope, lens_x, hn::Mul(X, inverse));
            const VF y = hn::MulAdd(slope, lens_y, hn::Mul(Y, inverse));
            const VI column = hn::Sub(hn::ConvertTo(sn, hn::Floor(hn::Mul(x, per_width))), column0);
            const VI row = hn::Sub(hn::ConvertTo(sn, hn::Floor(hn::Mul(y, per_height))), row0);
            const auto in_x = hn::And(hn::Gt(column, none), hn::Lt(column, columns));
            const auto in_y = hn::And(hn::Gt(row, none), hn::Lt(row, rows));
            const auto in = hn::And(hn::RebindMask(f, hn::And(in_x, in_y)), hn::Gt(W, zero));
            const VI cell = hn::Add(hn::Mul(row, pitch), column);

            const VF sb = slope_byte(slope);
            lowest[0] = hn::Min(lowest[0], hn::IfThenElse(in, sb, most));
            highest[0] = hn::Max(highest[0], hn::IfThenElse(in, sb, zero));
            VU traits = hn::BitCast(un, hn::ConvertTo(sn, hn::Min(hn::Max(sb, zero), most)));
            if constexpr (moving) {
                const VF vx = hn::Mul(inverse, hn::NegMulAdd(VW, hn::Sub(x, own_x), VX));
                const VF vy = hn::Mul(inverse, hn::NegMulAdd(VW, hn::Sub(y, own_y), VY));
                const VF xb = vx_byte(vx), yb = vy_byte(vy);
                lowest[1] = hn::Min(lowest[1], hn::IfThenElse(in, xb, most));
                highest[1] = hn::Max(highest[1], hn::IfThenElse(in, xb, zero));
                lowest[2] = hn::Min(lowest[2], hn::IfThenElse(in, yb, most));
                highest[2] = hn::Max(highest[2], hn::IfThenElse(in, yb, zero));
                const VU qx = hn::BitCast(un, hn::ConvertTo(sn, hn::Min(hn::Max(xb, zero), most)));
                const VU qy = hn::BitCast(un, hn::ConvertTo(sn, hn::Min(hn::Max(yb, zero), most)));
                traits = hn::Or(traits, hn::Or(hn::ShiftLeft<8>(qx), hn::ShiftLeft<16>(qy)));
            }
            const Pack pack(in);
            pack.store(x, &block.x[n]);
            pack.store(y, &block.y[n]);
            pack.store(hn::BitCast(un, cell), &block.cell[n]);
            pack.store(traits, &block.traits[n]);
            pack.store(hn::Iota(un, std::uint32_t(i)), &block.sample[n]);
            n += pack.count;
        }
    }
    out.samples = n;
    // The bytes hold only while none of them was cut off.
    out.spread = 0;
    for (int part = 0; part < (moving ? 3 : 1); ++part) {
        const float low = hn::GetLane(hn::MinOfLanes(f, lowest[part]));
        const float high = hn::GetLane(hn::MaxOfLanes(f, highest[part]));
        if (n == 0) break;
        if (!(low >= 0.0f && high <= 255.0f)) {
            out.spread = 0xffffffffu;
            break;
        }
        out.spread |= std::uint32_t(int(high) - int(low)) << (8 * part);
    }
}

// Puts what project_groups left in order of cells.
void sort_into_cells(Block& block, Projection& out) {
    const size_t n = out.samples, pitch = size_t(out.columns) + 1, cells = pitch * size_t(out.rows);
    out.start.assign(cells + 1, 0);
    std::uint32_t* count = out.start.data();
    for (size_t i = 0; i < n; ++i) block.rank[i] = count[block.cell[i]]++;
    std::uint32_t sum = 0;
    for (size_t row = 0; row < size_t(out.rows); ++row) {
        std::uint32_t* of = count + row * pitch;
        for (size_t column = 0; column + 1 < pitch; ++column) {
            const std::uint32_t here = of[column];
            of[column] = sum;
            sum += here;
        }
        of[pitch - 1] = sum;
        sum += Projection::padding;
    }
    out.start[cells] = sum;
    const size_t need = sum + lanes;
    if (out.x.size() < need) {
        out.x.resize(need + need / 4);
        out.y.resize(need + need / 4);
        out.sample.resize(need + need / 4);
        out.traits.resize(need + need / 4);
    }
    float *x = out.x.data(), *y = out.y.data();
    std::uint32_t *sample = out.sample.data(), *traits = out.traits.data();
    for (size_t i = 0; i < n; ++i) {
        const std::uint32_t to = count[block.cell[i]] + block.rank[i];
        x[to] = block.x[i];
        y[to] = block.y[i];
        sample[to] = block.sample[i];
        traits[to] = block.traits[i];
    }
    for (size_t row = 0; row < size_t(out.rows); ++row) {
        float* end = x + count[row * pitch + pitch - 1];
        std::fill(end, end + Projection::padding, 1e30f);
    }
}

}  // namespace

void project(const Hierarchy& h, Block& block, float u, float v, float t, Projection& out) {
    out.hierarchy = &h;
    out.u = u;
    out.v = v;
    out.t = t;
    out.reach = block.reach;
    out.cell_width = 0.5f * h.radius;
    out.cell_height = h.radius;
    // A cell more, so that rounding never asks for one that is not there.
    out.column0 = int(std::floor((float(block.x0) - block.reach) / out.cell_width)) - 1;
    out.row0 = int(std::floor((float(block.y0) - block.reach) / out.cell_height)) - 1;
    out.columns = int(std::floor((float(block.x1) + block.reach) / out.cell_width)) + 2 - out.column0;
    out.rows = int(std::floor((float(block.y1) + block.reach) / out.cell_height)) + 2 - out.row0;
    out.slope_step = block.slope_step;
    out.velocity_step = block.velocity_step;
    const float d = t - 0.5f;
    const size_t groups =
        find_groups(h, block, u, v, d, float(out.column0) * out.cell_width,
                    float(out.column0 + out.columns) * out.cell_width, float(out.row0) * out.cell_height,
                    float(out.row0 + out.rows) * out.cell_height);
    const size_t most = groups * Hierarchy::group_size + lanes;
    if (block.x.size() < most) {
        block.x.resize(most);
        block.y.resize(most);
        for (auto* values : {&block.cell, &block.sample, &block.traits, &block.rank}) values->resize(most);
    }
    if (h.moving) project_groups<true>(h, block, groups, u, v, d, out);
    else project_groups<false>(h, block, groups, u, v, d, out);
    sort_into_cells(block, out);
}

}  // namespace weft::light_field::WEFT_ISA
