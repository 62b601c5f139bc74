// Carries samples to lens centre and half time, and says where each goes in the hierarchy: plain
// loops, which the compiler makes vectors of; without fused multiply-adds, so that all instruction
// sets give the same bits.
#include <cmath>

#include "light-field/build_hierarchy_kernel.h"

namespace weft::light_field::WEFT_ISA {
namespace {

template <bool lens, bool moving>
void recentre_all(const Places& from, const Lens& by, size_t n, const Paths& to) {
    const float* __restrict xy = from.xy, * __restrict uv = from.uv, * __restrict t = from.t, * __restrict z = from.z, * __restrict motion = from.motion;
    float* __restrict X = to.X, * __restrict Y = to.Y, * __restrict W = to.W;
    float* __restrict VX = to.VX, * __restrict VY = to.VY, * __restrict VW = to.VW;
    for (size_t i = 0; i < n; ++i) {
        const bool far = z[i] == INFINITY;
        const float c = by.c0 / z[i] + by.c1, w = far ? 1.0f : z[i], scale = far ? far_depth : 1.0f;
        float x = xy[2 * i], y = xy[2 * i + 1];
        if constexpr (lens) {
            x -= c * by.aspect * uv[2 * i];
            y -= c * uv[2 * i + 1];
        }
        float px = x * w, py = y * w, pw = w;
        if constexpr (moving) {
            const float d = 0.5f - t[i];
            px += d * motion[3 * i];
            py += d * motion[3 * i + 1];
            pw += d * motion[3 * i + 2];
            VX[i] = motion[3 * i] * scale;
            VY[i] = motion[3 * i + 1] * scale;
            VW[i] = motion[3 * i + 2] * scale;
        }
        X[i] = px * scale;
        Y[i] = py * scale;
        W[i] = pw * scale;
    }
}

// The bits of a number below 2^16, each followed by a zero.
inline std::uint32_t spread_bits(std::uint32_t x) {
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

// The whole part of a value, within [0, most].
inline std::uint32_t clamped(double value, double most) {
    const double low = value > 0 ? value : 0.0;
    return std::uint32_t(std::int32_t(low < most ? low : most));
}

template <bool moving>
void layer_keys(const Paths& p, const KeyGrid& grid, size_t n, std::uint64_t* __restrict keys) {
    const float* __restrict X = p.X, * __restrict Y = p.Y, * __restrict W = p.W;
    const float* __restrict VX = p.VX, * __restrict VY = p.VY, * __restrict VW = p.VW;
    for (size_t i = 0; i < n; ++i) {
        const bool there = W[i] > 0;
        const double w = there ? double(W[i]) : 1.0;
        const double px = there ? X[i] / w : grid.middle_x, py = there ? Y[i] / w : grid.middle_y;
        const double x = (px + grid.border) / grid.cell, y = (py + grid.border) / grid.cell;
        const std::uint32_t column = clamped(x, grid.columns), row = clamped(y, grid.rows);
        const double vx = moving ? (VX[i] - px * VW[i]) / w : 0.0,
                     vy = moving ? (VY[i] - py * VW[i]) / w : 0.0;
        // Steps small against what separates surfaces, so that groups are tight.
        const std::uint32_t slope = clamped(128 + grid.c0 / w + grid.c1, 255);
        const std::uint32_t velocity =
            clamped(8 + vx / 3 + 0.5, 15) << 4 | clamped(8 + vy / 3 + 0.5, 15);
        const std::uint32_t fine = spread_bits(clamped(8 * (x - double(column)), 7)) |
                                   spread_bits(clamped(8 * (y - double(row)), 7)) << 1;
        const std::uint32_t block = spread_bits(column) | spread_bits(row) << 1;
        keys[i] = std::uint64_t(block) << 22 | (slope << 14 | velocity << 6 | fine);
    }
}

}  // namespace

void recentre(const Places& from, const Lens& lens, size_t n, const Paths& to) {
    if (from.motion && from.uv)
        recentre_all<true, true>(from, lens, n, to);
    else if (from.motion)
        recentre_all<false, true>(from, lens, n, to);
    else if (from.uv)
        recentre_all<true, false>(from, lens, n, to);
    else
        recentre_all<false, false>(from, lens, n, to);
}

void sort_keys(const Paths& paths, const KeyGrid& grid, size_t n, std::uint64_t* keys) {
    if (grid.layers) {
        if (paths.VX)
            layer_keys<true>(paths, grid, n, keys);
        else
            layer_keys<false>(paths, grid, n, keys);
        return;
    }
    for (size_t i = 0; i < n; ++i) {
        const bool there = paths.W[i] > 0;
        const double x = there ? double(paths.X[i]) / paths.W[i] : grid.middle_x,
                     y = there ? double(paths.Y[i]) / paths.W[i] : grid.middle_y;
        const std::uint32_t column = clamped((x + grid.border) / grid.cell, grid.columns);
        const std::uint32_t row = clamped((y + grid.border) / grid.cell, grid.rows);
        keys[i] = std::uint64_t(row) * (std::uint64_t(grid.columns) + 1) + column;
    }
}

}  // namespace weft::light_field::WEFT_ISA
