// Tells the surfaces among a location's candidates apart.
#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {
namespace {

struct Sorted {
    float *x, *y, *slope_x, *slope_y, *velocity_x, *velocity_y;
};

// Depth, slope and velocity of a location's candidates, by lookup in the hierarchy.
void look_up(const Candidates& c, size_t l, ClusterScratch& scratch) {
    const Hierarchy& h = *c.hierarchy;
    const size_t first = c.offset[l], n = c.of(l);
    const size_t room = n + lanes;
    if (scratch.depth.size() < room) {
        for (auto* values : {&scratch.depth, &scratch.x, &scratch.y, &scratch.slope_x, &scratch.slope_y,
                             &scratch.velocity_x, &scratch.velocity_y})
            values->resize(2 * room);
        scratch.rank.resize(2 * room);
        scratch.at.resize(2 * room);
        scratch.sorted.resize(6 * 2 * room);
    }
    const float u = c.u_of(l), v = c.v_of(l), d = c.t_of(l) - 0.5f;
    const VF time = hn::Set(f, d), c0 = hn::Set(f, h.lens.c0), c1 = hn::Set(f, h.lens.c1), one = hn::Set(f, 1.0f);
    const VF aspect = hn::Set(f, h.lens.aspect);
    const VF at_x = hn::Set(f, c.x[l] - h.lens.c1 * u * h.lens.aspect), at_y = hn::Set(f, c.y[l] - h.lens.c1 * v);
    const std::uint32_t* sample = &c.sample[first];
    if (h.moving) {
        for (size_t i = 0; i < n; ++i) {
            const std::uint32_t j = sample[i];
            scratch.depth[i] = h.W[j];
            scratch.velocity_x[i] = h.VX[j];
            scratch.velocity_y[i] = h.VY[j];
            scratch.slope_y[i] = h.VW[j];
        }
        for (size_t i = 0; i < n; i += lanes) {
            const VF VW = hn::LoadU(f, &scratch.slope_y[i]);
            const VF depth = hn::MulAdd(time, VW, hn::LoadU(f, &scratch.depth[i])), inverse = hn::Div(one, depth);
            const VF slope = hn::MulAdd(c0, inverse, c1);
            const VF x = hn::Add(at_x, hn::LoadU(f, &c.dx[first + i])), y = hn::Add(at_y, hn::LoadU(f, &c.dy[first + i]));
            const VF vx = hn::Mul(inverse, hn::NegMulAdd(VW, x, hn::LoadU(f, &scratch.velocity_x[i])));
            const VF vy = hn::Mul(inverse, hn::NegMulAdd(VW, y, hn::LoadU(f, &scratch.velocity_y[i])));
            hn::StoreU(depth, f, &scratch.depth[i]);
            hn::StoreU(hn::Mul(slope, aspect), f, &scratch.slope_x[i]);
            hn::StoreU(slope, f, &scratch.slope_y[i]);
            hn::StoreU(vx, f, &scratch.velocity_x[i]);
            hn::StoreU(vy, f, &scratch.velocity_y[i]);
        }
    } else {
        for (size_t i = 0; i < n; ++i) scratch.depth[i] = h.W[sample[i]];
        for (size_t i = 0; i < n; i += lanes) {
            const VF slope = hn::MulAdd(c0, hn::Div(one, hn::LoadU(f, &scratch.depth[i])), c1);
            hn::StoreU(hn::Mul(slope, aspect), f, &scratch.slope_x[i]);
            hn::StoreU(slope, f, &scratch.slope_y[i]);
            hn::StoreU(hn::Zero(f), f, &scratch.velocity_x[i]);
            hn::StoreU(hn::Zero(f), f, &scratch.velocity_y[i]);
        }
    }
}

// Place of each in order of depth; equal ones keep their order.
void rank_by_depth(const float* depth, size_t n, std::uint32_t* rank) {
    for (size_t i = 0; i < n; i += lanes) {
        const VF mine = hn::LoadU(f, depth + i);
        VI places = hn::Zero(sn);  // counted downwards: a true mask is -1
        const size_t end = std::min(i + lanes, n);
        for (size_t j = 0; j < i; ++j)
            places = hn::Add(places, hn::VecFromMask(sn, hn::RebindMask(sn, hn::Le(hn::Set(f, depth[j]), mine))));
        const VI me = hn::Iota(sn, std::int32_t(i));
        for (size_t j = i; j < end; ++j) {
            const VF other = hn::Set(f, depth[j]);
            const auto before = hn::Gt(me, hn::Set(sn, std::int32_t(j)));
            const auto less = hn::RebindMask(sn, hn::Lt(other, mine));
            const auto equal = hn::And(hn::RebindMask(sn, hn::Eq(other, mine)), before);
            places = hn::Add(places, hn::VecFromMask(sn, hn::Or(less, equal)));
        }
        for (size_t j = end; j < n; ++j)
            places = hn::Add(places, hn::VecFromMask(sn, hn::RebindMask(sn, hn::Lt(hn::Set(f, depth[j]), mine))));
        hn::StoreU(hn::BitCast(hn::RebindToUnsigned<F>(), hn::Neg(places)), hn::RebindToUnsigned<F>(), rank + i);
    }
}

// Front to back: a sample that conflicts with one of the open surface begins the next.
std::uint16_t split(const Sorted& a, size_t n, const SameSurface& test, std::uint32_t* at, std::uint16_t* surface) {
    const VF tolerance = hn::Set(f, test.tolerance);
    // Slopes and velocities come scaled by the box, so that |difference| is the way two samples move
    // against each other inside it.
    std::uint16_t now = 0;
    size_t open = 0;
    surface[at[0]] = 0;
    float low_x = a.velocity_x[0], high_x = low_x, low_y = a.velocity_y[0], high_y = low_y;
    for (size_t i = 1; i < n; ++i) {
        const float vx = a.velocity_x[i], vy = a.velocity_y[i];
        low_x = std::min(low_x, vx);
        high_x = std::max(high_x, vx);
        low_y = std::min(low_y, vy);
        high_y = std::max(high_y, vy);
        // Slopes ascend with depth or descend with it, so the first differs most.
        const float slopes = std::max(std::abs(a.slope_x[i] - a.slope_x[open]), std::abs(a.slope_y[i] - a.slope_y[open]));
        bool conflict = false;
        if (slopes > test.tolerance || high_x - low_x > test.tolerance || high_y - low_y > test.tolerance) {
            const VF x = hn::Set(f, a.x[i]), y = hn::Set(f, a.y[i]), sx = hn::Set(f, a.slope_x[i]);
            const VF sy = hn::Set(f, a.slope_y[i]), wx = hn::Set(f, vx), wy = hn::Set(f, vy);
            for (size_t j = open; j < i && !conflict; j += lanes) {
                const VF dx = hn::Add(hn::AbsDiff(hn::LoadU(f, a.x + j), x), tolerance);
                const VF dy = hn::Add(hn::AbsDiff(hn::LoadU(f, a.y + j), y), tolerance);
                const VF cx = hn::Max(hn::AbsDiff(hn::LoadU(f, a.slope_x + j), sx),
                                      hn::AbsDiff(hn::LoadU(f, a.velocity_x + j), wx));
                const VF cy = hn::Max(hn::AbsDiff(hn::LoadU(f, a.slope_y + j), sy),
                                      hn::AbsDiff(hn::LoadU(f, a.velocity_y + j), wy));
                const auto crosses = hn::And(hn::Or(hn::Lt(dx, cx), hn::Lt(dy, cy)), hn::FirstN(f, i - j));
                conflict = !hn::AllFalse(f, crosses);
            }
        }
        if (conflict) {
            ++now;
            open = i;
            low_x = high_x = vx;
            low_y = high_y = vy;
        }
        surface[at[i]] = now;
    }
    return std::uint16_t(now + 1);
}

std::uint16_t cluster_one(const Candidates& c, size_t l, const SameSurface& test, ClusterScratch& scratch,
                          std::uint16_t* surface) {
    const size_t first = c.offset[l], n = c.of(l);
    look_up(c, l, scratch);
    const float* depth = scratch.depth.data();
    if (n <= 128) {
        rank_by_depth(depth, n, scratch.rank.data());
        for (size_t i = 0; i < n; ++i) scratch.at[scratch.rank[i]] = std::uint32_t(i);
    } else {
        for (size_t i = 0; i < n; ++i) scratch.at[i] = std::uint32_t(i);
        std::sort(scratch.at.begin(), scratch.at.begin() + std::ptrdiff_t(n), [&](std::uint32_t a, std::uint32_t b) {
            return depth[a] != depth[b] ? depth[a] < depth[b] : a < b;
        });
    }
    const size_t room = scratch.sorted.size() / 6;
    float* p = scratch.sorted.data();
    const Sorted a{p, p + room, p + 2 * room, p + 3 * room, p + 4 * room, p + 5 * room};
    const float slope_way = test.box, velocity_way = 0.5f * test.box;
    for (size_t i = 0; i < n; ++i) {
        const std::uint32_t k = scratch.at[i];
        a.x[i] = c.dx[first + k];
        a.y[i] = c.dy[first + k];
        a.slope_x[i] = scratch.slope_x[k] * slope_way;
        a.slope_y[i] = scratch.slope_y[k] * slope_way;
        a.velocity_x[i] = scratch.velocity_x[k] * velocity_way;
        a.velocity_y[i] = scratch.velocity_y[k] * velocity_way;
    }
    return split(a, n, test, scratch.at.data(), surface);
}

}  // namespace

void cluster(const Candidates& c, const SameSurface& test, ClusterScratch& scratch, Surfaces& out) {
    const size_t n = c.size(), candidates = n ? c.offset[n] : 0;
    out.count_of.resize(n);
    if (out.surface.size() < candidates) out.surface.resize(candidates + candidates / 4);
    std::fill(out.surface.begin(), out.surface.begin() + std::ptrdiff_t(candidates), std::uint16_t(0));
    // No two candidates can conflict where these hold (Candidates::spread).
    const auto bound = [&](float way, float step) {
        return std::int32_t(std::floor(std::clamp(way > 0 ? test.tolerance / (way * step) - 1.0f : 1e9f, -1.0f, 255.0f)));
    };
    const float stretch = std::max(1.0f, c.hierarchy->lens.aspect);
    const std::int32_t slope = bound(test.box * stretch, c.slope_step), velocity = bound(0.5f * test.box, c.velocity_step);
    for (size_t l = 0; l < n; ++l) {
        const std::uint32_t spread = c.spread[l];
        const bool one = spread != 0xffffffffu && std::int32_t(spread & 255) <= slope &&
                         std::int32_t(spread >> 8 & 255) <= velocity && std::int32_t(spread >> 16 & 255) <= velocity;
        if (one || c.of(l) < 2) out.count_of[l] = c.of(l) > 0;
        else out.count_of[l] = cluster_one(c, l, test, scratch, &out.surface[c.offset[l]]);
    }
}

}  // namespace weft::light_field::WEFT_ISA
