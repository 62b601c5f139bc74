// Carries a block's samples to one (u, v, t) and sorts them into a grid.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "light-field/group_test.h"
#include "light-field/kernels.h"
#include "light-field/path_vectors.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {
namespace {

// Whether rectangles hold cells that are wanted, by blocks of cells: how many of these are, of all up
// to some column and row.
class WantedBlocks {
  public:
    WantedBlocks(const Projection& p, WantedCells& wanted)
        : sums_(wanted.sums),
          pitch_((p.columns + wide - 1) / wide + 1),
          per_width_(hn::Set(f, 1.0f / p.cell_width)),
          per_height_(hn::Set(f, 1.0f / p.cell_height)),
          column0_(hn::Set(f, float(p.column0))),
          row0_(hn::Set(f, float(p.row0))),
          last_column_(hn::Set(f, float(p.columns - 1))),
          last_row_(hn::Set(f, float(p.rows - 1))) {
        static_assert(wide == sizeof(std::uint32_t));
        const int rows = (p.rows + high - 1) / high;
        sums_.assign(size_t(rows + 1) * size_t(pitch_), 0);
        for (int row = 0; row < rows; ++row) {
            const std::int32_t* before = &sums_[size_t(row) * size_t(pitch_)];
            std::int32_t *here = &sums_[size_t(row + 1) * size_t(pitch_)], count = 0;
            const int last = std::min(row * high + high, p.rows);
            for (int column = 1; column < pitch_; ++column) {
                std::uint32_t any = 0;
                for (int r = row * high; r < last; ++r) {
                    std::uint32_t some;
                    std::memcpy(&some, &wanted.cells[size_t(r) * size_t(p.columns + 1) +
                                                     size_t((column - 1) * wide)], sizeof(some));
                    any |= some;
                }
                here[column] = before[column] + (count += any != 0);
            }
        }
    }
    HWY_INLINE auto operator()(VF left, VF right, VF top, VF bottom) const {
        const VI pitch = hn::Set(sn, pitch_), one = hn::Set(sn, 1);
        const auto block = [](VF at, VF per_cell, VF first, VF last, auto each) HWY_ATTR {
            const VF cell = hn::Sub(hn::Floor(hn::Mul(at, per_cell)), first);
            return hn::ShiftRight<each()>(
                hn::ConvertTo(sn, hn::Max(hn::Zero(f), hn::Min(cell, last))));
        };
        const auto column = [&](VF at) HWY_ATTR {
            return block(at, per_width_, column0_, last_column_, std::integral_constant<int, 2>());
        };
        const auto row = [&](VF at) HWY_ATTR {
            return hn::Mul(pitch, block(at, per_height_, row0_, last_row_,
                                        std::integral_constant<int, 1>()));
        };
        const auto before = [&](VI in_row, VI in_column) HWY_ATTR {
            return hn::GatherIndex(sn, sums_.data(), hn::Add(in_row, in_column));
        };
        const VI x0 = column(left), x1 = hn::Add(column(right), one), y0 = row(top),
                 y1 = hn::Add(row(bottom), pitch);
        return hn::RebindMask(f, hn::Ne(hn::Sub(before(y1, x1), before(y1, x0)),
                                        hn::Sub(before(y0, x1), before(y0, x0))));
    }

  private:
    static constexpr int wide = 4, high = 2;  // cells
    std::vector<std::int32_t>& sums_;
    const int pitch_;
    const VF per_width_, per_height_, column0_, row0_, last_column_, last_row_;
};

// The groups whose bounds at (u, v, t) touch the grid, and of it cells that are wanted, if given.
size_t find_groups(const Hierarchy& h, Block& block, float u, float v, float d, float x0, float x1,
                   float y0, float y1, const WantedBlocks* wanted) {
    const GroupTest test(h, u, v, d, x0, x1, y0, y1);
    size_t found = 0;
    for (size_t i = 0; i < block.groups; i += lanes) {
        auto in = test(block, i);
        if (hn::AllFalse(f, in)) continue;
        if (wanted) {
            const auto at = test.bounds(block, i);
            in = hn::And(in, (*wanted)(at.left, at.right, at.top, at.bottom));
        }
        const Pack pack(in);
        pack.store(hn::LoadU(un, &block.group[i]), &block.seen[found]);
        found += pack.count;
    }
    return found;
}

// A byte of the traits, as a float that may lie outside [0, 255].
struct Quantity {
    VF low, scale;
    Quantity(float from, float step) : low(hn::Set(f, from)), scale(hn::Set(f, 1.0f / step)) {}
    HWY_INLINE VF operator()(VF value) const { return hn::Mul(hn::Sub(value, low), scale); }
};

struct Projector {
    const Hierarchy& h;
    Block& block;
    Projection& out;
    const VF one = hn::Set(f, 1.0f), zero = hn::Zero(f), most = hn::Set(f, 255.0f);
    const VF c0, c1, time, lens_x, lens_y, own_x, own_y, per_width, per_height;
    const VF column0, row0, columns, rows;
    const VU pitch;
    const Quantity slope_byte, vx_byte, vy_byte;
    const VU standing;  // velocity bytes of what does not move
    const std::uint8_t* wanted = nullptr;
    Spread spread;
    size_t n = 0;

    Projector(const Hierarchy& hierarchy, Block& b, float u, float v, float d,
              Projection& projection)
        : h(hierarchy),
          block(b),
          out(projection),
          c0(hn::Set(f, h.lens.c0)),
          c1(hn::Set(f, h.lens.c1)),
          time(hn::Set(f, d)),
          lens_x(hn::Set(f, u * h.lens.aspect)),
          lens_y(hn::Set(f, v)),
          own_x(hn::Set(f, h.lens.c1 * u * h.lens.aspect)),
          own_y(hn::Set(f, h.lens.c1 * v)),
          per_width(hn::Set(f, 1.0f / out.cell_width)),
          per_height(hn::Set(f, 1.0f / out.cell_height)),
          column0(hn::Set(f, float(out.column0))),
          row0(hn::Set(f, float(out.row0))),
          columns(hn::Set(f, float(out.columns))),
          rows(hn::Set(f, float(out.rows))),
          pitch(hn::Set(un, std::uint32_t(out.columns + 1))),
          slope_byte(b.slope_low, b.slope_step),
          vx_byte(b.velocity_x_low, b.velocity_step),
          vy_byte(b.velocity_y_low, b.velocity_step),
          standing(velocity_traits(vx_byte(zero), vy_byte(zero))) {}

    // Whole numbers below 2^23, in the low bits. (A conversion takes care of what does not fit.)
    HWY_INLINE static VU low_bits(VF value) {
        return hn::BitCast(un, hn::Add(value, hn::Set(f, 0x1p+23f)));
    }
    HWY_INLINE static VU whole(VF value) { return hn::And(low_bits(value), hn::Set(un, 0x7fffff)); }
    // The byte of a quantity, in place; with the fourth where it does not fit into its own.
    template <int shift>
    HWY_INLINE VU trait(VF value) const {
        const VF fit = hn::Min(hn::Max(value, zero), most);
        const VU byte = shift == 0 ? hn::And(low_bits(fit), hn::Set(un, 255))
                                   : hn::ShiftLeft<shift>(low_bits(fit));
        return hn::Or(byte, hn::IfThenZeroElse(hn::RebindMask(un, hn::Eq(value, fit)),
                                               hn::Set(un, 0xff000000u)));
    }
    HWY_INLINE VU velocity_traits(VF x, VF y) const { return hn::Or(trait<8>(x), trait<16>(y)); }

    template <bool moving, bool depths>
    HWY_INLINE void group(size_t begin) {
        for (size_t i = begin; i < begin + Hierarchy::group_size; i += lanes) {
            VF X = hn::LoadU(f, &h.X[i]), Y = hn::LoadU(f, &h.Y[i]), W, VX, VY, VW;
            if constexpr (moving) {
                const PathVectors path(&h.paths[4 * i]);
                VX = path.VX, VY = path.VY, VW = path.VW;
                X = hn::MulAdd(time, VX, X);
                Y = hn::MulAdd(time, VY, Y);
                W = hn::MulAdd(time, VW, path.W);
            } else {
                W = hn::LoadU(f, &h.W[i]);
            }
            const VF inverse = hn::Div(one, W);
            const VF slope = hn::MulAdd(c0, inverse, c1);
            const VF x = hn::MulAdd(slope, lens_x, hn::Mul(X, inverse));
            const VF y = hn::MulAdd(slope, lens_y, hn::Mul(Y, inverse));
            const VF column = hn::Sub(hn::Floor(hn::Mul(x, per_width)), column0),
                     row = hn::Sub(hn::Floor(hn::Mul(y, per_height)), row0);
            const auto in_x = hn::And(hn::Ge(column, zero), hn::Lt(column, columns)),
                       in_y = hn::And(hn::Ge(row, zero), hn::Lt(row, rows));
            auto in = hn::And(hn::And(in_x, in_y), hn::Gt(W, zero));
            VU cell = hn::Add(hn::Mul(whole(row), pitch), whole(column));
            VU traits = depths ? hn::BitCast(un, inverse) : trait<0>(slope_byte(slope));
            if constexpr (depths) {
                cell = hn::IfThenElseZero(hn::RebindMask(un, in), cell);
                const VU byte =
                    hn::And(hn::GatherOffset(un, reinterpret_cast<const std::uint32_t*>(wanted),
                                             hn::BitCast(sn, cell)),
                            hn::Set(un, 255));
                in = hn::And(in, hn::RebindMask(f, hn::Ne(byte, hn::Zero(un))));
            } else if constexpr (moving)
                traits = hn::Or(
                    traits,
                    velocity_traits(
                        vx_byte(hn::Mul(inverse, hn::NegMulAdd(VW, hn::Sub(x, own_x), VX))),
                        vy_byte(hn::Mul(inverse, hn::NegMulAdd(VW, hn::Sub(y, own_y), VY)))));
            else
                traits = hn::Or(traits, standing);
            if constexpr (!depths) spread.add(traits, in);
            const Pack pack(in);
            pack.store(x, &block.x[n]);
            pack.store(y, &block.y[n]);
            pack.store(cell, &block.cell[n]);
            pack.store(traits, &block.traits[n]);
            pack.store(numbers_from(std::uint32_t(i)), &block.sample[n]);
            n += pack.count;
        }
    }
};

template <bool depths>
void project_groups(const Hierarchy& h, Block& block, size_t groups, const std::uint8_t* wanted,
                    float u, float v, float d, Projection& out) {
    Projector to(h, block, u, v, d, out);
    to.wanted = wanted;
    for (size_t k = 0; k < groups; ++k) {
        const std::uint32_t g = block.seen[k];
        if (h.groups.moves[g])
            to.group<true, depths>(size_t(g) * Hierarchy::group_size);
        else
            to.group<false, depths>(size_t(g) * Hierarchy::group_size);
    }
    out.samples = to.n;
    out.spread = depths ? 0xffffffffu : to.n == 0 ? 0 : to.spread.between();
}

// Writes n samples to where their cells start.
template <bool colored>
void put_entries(const Hierarchy& h, const Block& block, size_t n, Projection& out) {
    using Quad = hn::FixedTag<float, 4>;
    using Two = hn::Repartition<std::uint64_t, Quad>;
    const Quad q;
    const Two two;
    const float *x = block.x.data(), *y = block.y.data(), *from = h.rgba.data();
    const std::uint32_t *cell = block.cell.data(), *sample = block.sample.data(),
                        *traits = block.traits.data();
    std::uint32_t* next = out.start.data() + 1;
    float *to = &out.entries[0].x, *rgba = out.rgba.data();
    for (size_t i = 0; i < n; i += 4) {
        // Four values of each of four samples, transposed.
        const auto quad = [i, q](const auto* values) HWY_ATTR {
            return hn::LoadU(q, reinterpret_cast<const float*>(values + i));
        };
        const auto pair = [two](auto v) HWY_ATTR { return hn::BitCast(two, v); };
        const auto places = quad(x), heights = quad(y), samples = quad(sample),
                   bytes = quad(traits);
        const auto low = pair(hn::InterleaveLower(q, places, heights)),
                   high = pair(hn::InterleaveUpper(q, places, heights));
        const auto low_rest = pair(hn::InterleaveLower(q, samples, bytes)),
                   high_rest = pair(hn::InterleaveUpper(q, samples, bytes));
        const auto put = [&](size_t k, auto entry) HWY_ATTR {
            const size_t at = 4 * size_t(next[cell[i + k]]++);
            hn::StoreU(hn::BitCast(q, entry), q, to + at);
            if constexpr (colored)
                hn::StoreU(hn::LoadU(q, from + 4 * size_t(sample[i + k])), q, rgba + at);
        };
        put(0, hn::InterleaveLower(two, low, low_rest));
        put(1, hn::InterleaveUpper(two, low, low_rest));
        put(2, hn::InterleaveLower(two, high, high_rest));
        put(3, hn::InterleaveUpper(two, high, high_rest));
    }
}

// Puts what project_groups left in order of cells.
void sort_into_cells(const Hierarchy& h, Block& block, Projection& out) {
    const size_t n = out.samples, pitch = size_t(out.columns) + 1, cells = pitch * size_t(out.rows);
    // Each cell's start is kept one place late: there it moves on as samples are put, and ends as
    // the start of the next.
    out.start.assign(cells + 2, 0);
    std::uint32_t* late = out.start.data() + 1;
    for (size_t i = 0; i < n; ++i) ++late[block.cell[i]];
    std::uint32_t sum = 0;
    for (size_t row = 0; row < size_t(out.rows); ++row) {
        std::uint32_t* of = late + row * pitch;
        for (size_t column = 0; column + 1 < pitch; ++column) {
            const std::uint32_t here = of[column];
            of[column] = sum;
            sum += here;
        }
        sum += Projection::padding;
        of[pitch - 1] = sum;
    }
    late[cells] = sum;
    const size_t need = sum + lanes;
    if (out.entries.size() < need) out.entries.resize(need + need / 4);
    if (out.colored && out.rgba.size() < 4 * need) out.rgba.resize(5 * need);
    // Samples are put by fours: the last go with some that land past the end.
    for (size_t i = n; i < n + 3; ++i) {
        block.cell[i] = std::uint32_t(cells);
        block.sample[i] = 0;
    }
    if (out.colored)
        put_entries<true>(h, block, n, out);
    else
        put_entries<false>(h, block, n, out);
    for (size_t row = 0; row < size_t(out.rows); ++row)
        std::fill_n(&out.entries[out.start[row * pitch + pitch - 1]], Projection::padding,
                    Projection::Entry{1e30f, 1e30f, 0, 0});
}

// `depths`: of samples in wanted cells, 1/w in the place of traits.
template <bool depths>
void project_onto_grid(const Hierarchy& h, Block& block, WantedCells* wanted, float u, float v,
                       float t, Projection& out) {
    out.u = u;
    out.v = v;
    out.t = t;
    const float d = t - 0.5f;
    std::optional<WantedBlocks> blocks;
    if constexpr (depths) blocks.emplace(out, *wanted);
    const size_t groups = find_groups(h, block, u, v, d, float(out.column0) * out.cell_width,
                                      float(out.column0 + out.columns) * out.cell_width,
                                      float(out.row0) * out.cell_height,
                                      float(out.row0 + out.rows) * out.cell_height,
                                      depths ? &*blocks : nullptr);
    const size_t most = groups * Hierarchy::group_size + lanes;
    if (block.x.size() < most) {
        block.x.resize(most);
        block.y.resize(most);
        for (auto* values : {&block.cell, &block.sample, &block.traits}) values->resize(most);
    }
    project_groups<depths>(h, block, groups, depths ? wanted->cells.data() : nullptr, u, v, d, out);
    sort_into_cells(h, block, out);
}

}  // namespace

void project(const Hierarchy& h, Block& block, float u, float v, float t, bool colors,
             Projection& out) {
    lay_grid(h, block.x0, block.y0, block.x1, block.y1, block.reach, h.radius, out);
    out.colored = colors;
    out.slope_step = block.slope_step;
    out.velocity_step = block.velocity_step;
    project_onto_grid<false>(h, block, nullptr, u, v, t, out);
}

void project_depths(const Hierarchy& h, Block& block, WantedCells& wanted, float u, float v,
                    float t, Projection& out) {
    out.colored = false;
    project_onto_grid<true>(h, block, &wanted, u, v, t, out);
}

}  // namespace weft::light_field::WEFT_ISA
