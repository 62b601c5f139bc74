// Tells the surfaces among a location's candidates apart.
#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {
namespace {

// Arrays of one location's candidates; in order of depth once sorted. Slopes and velocities are scaled by
// the box, so that a difference is the way two samples move against each other inside it.
struct Paths {
    float *x, *y, *slope_x, *slope_y, *velocity_x, *velocity_y;
};
Paths paths_in(std::vector<float>& memory) {
    const size_t room = memory.size() / 6;
    float* p = memory.data();
    return {p, p + room, p + 2 * room, p + 3 * room, p + 4 * room, p + 5 * room};
}

void grow(ClusterScratch& scratch, size_t n) {
    const size_t room = n + 4 * lanes;
    if (scratch.depth.size() >= room) return;
    scratch.depth.resize(2 * room);
    scratch.rank.resize(2 * room);
    scratch.at.resize(2 * room);
    scratch.found.resize(6 * 2 * room);
    scratch.sorted.resize(6 * 2 * room);
}

// What the candidates do, by lookup in the hierarchy. `velocities`: whether these matter.
void look_up(const Candidates& c, size_t l, const SameSurface& test, bool velocities, ClusterScratch& scratch) {
    const Hierarchy& h = *c.hierarchy;
    const size_t first = c.offset[l], n = c.of(l);
    const Paths found = paths_in(scratch.found);
    float* depth = scratch.depth.data();
    const std::uint32_t* sample = &c.sample[first];
    const float u = c.u_of(l), v = c.v_of(l), d = c.t_of(l) - 0.5f;
    const VF c0 = hn::Set(f, h.lens.c0 * test.box), c1 = hn::Set(f, h.lens.c1 * test.box), one = hn::Set(f, 1.0f);
    const VF time = hn::Set(f, d), way = hn::Set(f, 0.5f * test.box);
    const VF at_x = hn::Set(f, c.x[l] - h.lens.c1 * u * h.lens.aspect), at_y = hn::Set(f, c.y[l] - h.lens.c1 * v);
    for (size_t i = 0; i < n; ++i) depth[i] = h.W[sample[i]];
    if (h.moving) {
        float* VW = found.slope_y;
        for (size_t i = 0; i < n; ++i) VW[i] = h.velocity(sample[i]).w;
        for (size_t i = 0; i < n; i += lanes)
            hn::StoreU(hn::MulAdd(time, hn::LoadU(f, VW + i), hn::LoadU(f, depth + i)), f, depth + i);
        if (velocities) {
            for (size_t i = 0; i < n; ++i) {
                const Hierarchy::Velocity velocity = h.velocity(sample[i]);
                found.velocity_x[i] = velocity.x;
                found.velocity_y[i] = velocity.y;
            }
            for (size_t i = 0; i < n; i += lanes) {
                const VF inverse = hn::Div(way, hn::LoadU(f, depth + i)), w = hn::LoadU(f, VW + i);
                const VF x = hn::Add(at_x, hn::LoadU(f, &c.dx[first + i])), y = hn::Add(at_y, hn::LoadU(f, &c.dy[first + i]));
                hn::StoreU(hn::Mul(inverse, hn::NegMulAdd(w, x, hn::LoadU(f, found.velocity_x + i))), f, found.velocity_x + i);
                hn::StoreU(hn::Mul(inverse, hn::NegMulAdd(w, y, hn::LoadU(f, found.velocity_y + i))), f, found.velocity_y + i);
            }
        }
    }
    for (size_t i = 0; i < n; i += lanes)
        hn::StoreU(hn::MulAdd(c0, hn::Div(one, hn::LoadU(f, depth + i)), c1), f, found.slope_y + i);
}

// Place of each in order of depth; equal ones keep their order. Four vectors at a time, each against all.
void rank_by_depth(const float* depth, size_t n, std::uint32_t* rank) {
    for (size_t i = 0; i < n; i += 4 * lanes) {
        VF mine[4];
        VI place[4];  // counted downwards: a true mask is -1
        for (size_t k = 0; k < 4; ++k) {
            mine[k] = hn::LoadU(f, depth + i + k * lanes);
            place[k] = hn::Zero(sn);
        }
        const auto count = [&](auto mask, size_t k) HWY_ATTR { place[k] = hn::Add(place[k], hn::VecFromMask(sn, hn::RebindMask(sn, mask))); };
        // Those that come before all of these in order win ties, those after lose them.
        size_t j = 0;
        for (; j < i; ++j) {
            const VF other = hn::Set(f, depth[j]);
            for (size_t k = 0; k < 4; ++k) count(hn::Le(other, mine[k]), k);
        }
        const auto among = [&]<size_t own>() HWY_ATTR {
            const VI me = hn::BitCast(sn, numbers_from(std::uint32_t(j)));
            for (const size_t end = std::min(j + lanes, n); j < end; ++j) {
                const VF other = hn::Set(f, depth[j]);
                for (size_t k = 0; k < own; ++k) count(hn::Lt(other, mine[k]), k);
                const auto tie = hn::And(hn::Eq(other, mine[own]), hn::RebindMask(f, hn::Gt(me, hn::Set(sn, std::int32_t(j)))));
                count(hn::Or(hn::Lt(other, mine[own]), tie), own);
                for (size_t k = own + 1; k < 4; ++k) count(hn::Le(other, mine[k]), k);
            }
        };
        among.template operator()<0>();
        among.template operator()<1>();
        among.template operator()<2>();
        among.template operator()<3>();
        for (; j < n; ++j) {
            const VF other = hn::Set(f, depth[j]);
            for (size_t k = 0; k < 4; ++k) count(hn::Lt(other, mine[k]), k);
        }
        for (size_t k = 0; k < 4; ++k) hn::StoreU(hn::BitCast(un, hn::Neg(place[k])), un, rank + i + k * lanes);
    }
}

// Which of [i, i + lanes) may conflict with some sample of the surface begun by `open`: slopes ascend with
// depth or descend with it, so that of the first differs most; of velocities, none differ by more than twice
// what they differ from the first by.
template <bool velocities>
unsigned suspects(const Paths& a, size_t i, size_t open, size_t n, float tolerance) {
    const VF limit = hn::Set(f, tolerance), half = hn::Set(f, 0.5f * tolerance);
    auto found = hn::Or(hn::Gt(hn::AbsDiff(hn::LoadU(f, a.slope_x + i), hn::Set(f, a.slope_x[open])), limit),
                        hn::Gt(hn::AbsDiff(hn::LoadU(f, a.slope_y + i), hn::Set(f, a.slope_y[open])), limit));
    if constexpr (velocities) {
        found = hn::Or(found, hn::Gt(hn::AbsDiff(hn::LoadU(f, a.velocity_x + i), hn::Set(f, a.velocity_x[open])), half));
        found = hn::Or(found, hn::Gt(hn::AbsDiff(hn::LoadU(f, a.velocity_y + i), hn::Set(f, a.velocity_y[open])), half));
    }
    return bits_of(f, hn::And(found, hn::FirstN(f, n - i)));
}

// Whether sample i conflicts with one of [open, i).
template <bool velocities>
bool conflicts(const Paths& a, size_t i, size_t open, float tolerance) {
    const VF limit = hn::Set(f, tolerance), x = hn::Set(f, a.x[i]), y = hn::Set(f, a.y[i]);
    const VF sx = hn::Set(f, a.slope_x[i]), sy = hn::Set(f, a.slope_y[i]);
    for (size_t j = open; j < i; j += lanes) {
        VF way_x = hn::AbsDiff(hn::LoadU(f, a.slope_x + j), sx), way_y = hn::AbsDiff(hn::LoadU(f, a.slope_y + j), sy);
        if constexpr (velocities) {
            way_x = hn::Max(way_x, hn::AbsDiff(hn::LoadU(f, a.velocity_x + j), hn::Set(f, a.velocity_x[i])));
            way_y = hn::Max(way_y, hn::AbsDiff(hn::LoadU(f, a.velocity_y + j), hn::Set(f, a.velocity_y[i])));
        }
        const auto in_x = hn::Lt(hn::Add(hn::AbsDiff(hn::LoadU(f, a.x + j), x), limit), way_x);
        const auto in_y = hn::Lt(hn::Add(hn::AbsDiff(hn::LoadU(f, a.y + j), y), limit), way_y);
        if (!hn::AllFalse(f, hn::And(hn::Or(in_x, in_y), hn::FirstN(f, i - j)))) return true;
    }
    return false;
}

// Front to back: a sample that conflicts with one of the open surface begins the next. Writes where each
// surface begins; returns how many there are.
template <bool velocities>
size_t split(const Paths& a, size_t n, float tolerance, std::uint32_t* begins) {
    size_t surfaces = 1, open = 0;
    bool mixed = false;  // a sample unlike the first is among the surface's: all that follow are suspect
    begins[0] = 0;
    for (size_t i = 0; i < n; i += lanes) {
        const unsigned all = n - i < lanes ? (1u << (n - i)) - 1 : (1u << lanes) - 1;
        unsigned left = mixed ? all : suspects<velocities>(a, i, open, n, tolerance);
        while (left) {
            const size_t at = i + size_t(__builtin_ctz(left));
            const unsigned later = ~((2u << (at - i)) - 1);
            left &= later;
            if (!conflicts<velocities>(a, at, open, tolerance)) {
                if (velocities && !mixed) left = all & later;
                mixed = velocities;
                continue;
            }
            open = at;
            mixed = false;
            begins[surfaces++] = std::uint32_t(at);
            left = suspects<velocities>(a, i, open, n, tolerance) & later;
        }
    }
    return surfaces;
}

std::uint16_t cluster_one(const Candidates& c, size_t l, const SameSurface& test, bool velocities, ClusterScratch& scratch,
                          std::uint16_t* surface) {
    const size_t first = c.offset[l], n = c.of(l);
    grow(scratch, n);
    look_up(c, l, test, velocities, scratch);
    const float* depth = scratch.depth.data();
    std::uint32_t* at = scratch.at.data();
    if (n <= 128) {
        rank_by_depth(depth, n, scratch.rank.data());
        for (size_t i = 0; i < n; ++i) at[scratch.rank[i]] = std::uint32_t(i);
    } else {
        for (size_t i = 0; i < n; ++i) at[i] = std::uint32_t(i);
        std::sort(at, at + n, [&](std::uint32_t p, std::uint32_t q) { return depth[p] != depth[q] ? depth[p] < depth[q] : p < q; });
    }
    const Paths found = paths_in(scratch.found);
    Paths a = paths_in(scratch.sorted);
    const float *dx = &c.dx[first], *dy = &c.dy[first];
    for (size_t i = 0; i < n; ++i) {
        const std::uint32_t k = at[i];
        a.x[i] = dx[k];
        a.y[i] = dy[k];
        a.slope_y[i] = found.slope_y[k];
    }
    if (const float aspect = c.hierarchy->lens.aspect; aspect == 1) a.slope_x = a.slope_y;
    else
        for (size_t i = 0; i < n; ++i) a.slope_x[i] = aspect * a.slope_y[i];
    if (velocities)
        for (size_t i = 0; i < n; ++i) {
            a.velocity_x[i] = found.velocity_x[at[i]];
            a.velocity_y[i] = found.velocity_y[at[i]];
        }
    std::uint32_t* begins = scratch.rank.data();
    const size_t surfaces = velocities ? split<true>(a, n, test.tolerance, begins) : split<false>(a, n, test.tolerance, begins);
    for (size_t k = 1; k < surfaces; ++k)
        for (size_t i = begins[k], end = k + 1 < surfaces ? begins[k + 1] : n; i < end; ++i) surface[at[i]] = std::uint16_t(k);
    return std::uint16_t(surfaces);
}

}  // namespace

void cluster(const Candidates& c, const SameSurface& test, ClusterScratch& scratch, Surfaces& out) {
    const size_t n = c.size(), candidates = n ? c.offset[n] : 0;
    out.count_of.resize(n);
    constexpr size_t spare = 16;  // kernels read whole vectors
    if (out.surface.size() < candidates + spare) out.surface.resize(candidates + candidates / 4 + spare);
    std::fill(out.surface.begin(), out.surface.begin() + std::ptrdiff_t(candidates), std::uint16_t(0));
    // No two candidates can conflict where these hold (Candidates::spread).
    const auto bound = [&](float way, float step) {
        return std::int32_t(std::floor(std::clamp(way > 0 ? test.tolerance / (way * step) - 1.0f : 1e9f, -1.0f, 255.0f)));
    };
    const float stretch = std::max(1.0f, c.hierarchy->lens.aspect);
    const std::int32_t slope = bound(test.box * stretch, c.slope_step), velocity = bound(0.5f * test.box, c.velocity_step);
    for (size_t l = 0; l < n; ++l) {
        const std::uint32_t spread = c.spread[l];
        const bool known = spread != 0xffffffffu;
        const bool still = !c.hierarchy->moving ||
                           (known && std::int32_t(spread >> 8 & 255) <= velocity && std::int32_t(spread >> 16 & 255) <= velocity);
        if ((known && still && std::int32_t(spread & 255) <= slope) || c.of(l) < 2) out.count_of[l] = c.of(l) > 0;
        else out.count_of[l] = cluster_one(c, l, test, !still, scratch, &out.surface[c.offset[l]]);
    }
}

}  // namespace weft::light_field::WEFT_ISA
