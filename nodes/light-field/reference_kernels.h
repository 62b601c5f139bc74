// The kernels in their plainest form, one location at a time and every sample looked at: what the fast
// ones are tested against. Nothing here is meant to be fast.
// Source: Lehtinen et al. 2011, Sec. 3; see the nodes for where each follows it.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "light-field/hierarchy.h"
#include "light-field/kernels.h"
#include "light-field/streams.h"

namespace weft::light_field::reference {

// A sample at lens position (u, v) and time t; not `there` when behind the camera then.
struct Seen {
    bool there;
    float x, y, depth, slope_x, slope_y, velocity_x, velocity_y;
};
inline Seen see(const Hierarchy& h, size_t i, float u, float v, float t) {
    const float d = t - 0.5f;
    const auto [VX, VY, VW] = h.velocity(i);
    Seen s{};
    s.depth = h.W[i] + d * VW;
    s.there = s.depth > 0;
    s.slope_y = h.lens.c0 / s.depth + h.lens.c1;
    s.slope_x = s.slope_y * h.lens.aspect;
    s.x = (h.X[i] + d * VX) / s.depth + s.slope_x * u;
    s.y = (h.Y[i] + d * VY) / s.depth + s.slope_y * v;
    s.velocity_x = (VX - VW * (s.x - h.lens.c1 * h.lens.aspect * u)) / s.depth;
    s.velocity_y = (VY - VW * (s.y - h.lens.c1 * v)) / s.depth;
    return s;
}

// Samples within `radius` of (x, y).
inline std::vector<std::uint32_t> near(const Hierarchy& h, float x, float y, float u, float v, float t, float radius) {
    std::vector<std::uint32_t> found;
    for (size_t i = 0; i < h.size(); ++i) {
        const Seen s = see(h, i, u, v, t);
        const float dx = s.x - x, dy = s.y - y;
        if (s.there && dx * dx + dy * dy < radius * radius) found.push_back(std::uint32_t(i));
    }
    return found;
}

// Whether two trajectories cross near the location.
inline bool conflict(const Seen& a, const Seen& b, const SameSurface& test) {
    const auto crosses = [&](float distance, float slopes, float velocities) {
        return std::abs(distance) + test.tolerance < std::abs(slopes) * test.box ||
               std::abs(distance) + test.tolerance < std::abs(velocities) * 0.5f * test.box;
    };
    return crosses(a.x - b.x, a.slope_x - b.slope_x, a.velocity_x - b.velocity_x) ||
           crosses(a.y - b.y, a.slope_y - b.slope_y, a.velocity_y - b.velocity_y);
}

// Surface of each, front to back; samples in any order.
inline std::vector<std::uint16_t> cluster(std::span<const Seen> samples, const SameSurface& test) {
    std::vector<size_t> order(samples.size());
    for (size_t i = 0; i < order.size(); ++i) {
        size_t at = i;
        while (at > 0 && samples[order[at - 1]].depth > samples[i].depth) order[at] = order[at - 1], --at;
        order[at] = i;
    }
    std::vector<std::uint16_t> surface(samples.size());
    std::uint16_t now = 0;
    size_t open = 0;
    for (size_t i = 0; i < order.size(); ++i) {
        for (size_t j = open; j < i; ++j)
            if (conflict(samples[order[i]], samples[order[j]], test)) {
                ++now;
                open = i;
                break;
            }
        surface[order[i]] = now;
    }
    return surface;
}

// Whether the origin lies in the closed triangle a, b, c.
inline bool triangle_holds_origin(float ax, float ay, float bx, float by, float cx, float cy) {
    const float ab = ax * by - ay * bx, bc = bx * cy - by * cx, ca = cx * ay - cy * ax;
    return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

// Whether a triangle of the points, edges at most 2 radius long and a corner within radius, holds the origin.
inline bool surrounded(std::span<const float> x, std::span<const float> y, float radius) {
    const auto close = [&](size_t i, size_t j) {
        return (x[i] - x[j]) * (x[i] - x[j]) + (y[i] - y[j]) * (y[i] - y[j]) <= 4 * radius * radius;
    };
    const auto near = [&](size_t i) { return x[i] * x[i] + y[i] * y[i] <= radius * radius; };
    for (size_t i = 0; i < x.size(); ++i)
        for (size_t j = i + 1; j < x.size(); ++j)
            for (size_t k = j + 1; k < x.size(); ++k)
                if ((near(i) || near(j) || near(k)) && close(i, j) && close(j, k) && close(i, k) &&
                    triangle_holds_origin(x[i], y[i], x[j], y[j], x[k], y[k]))
                    return true;
    return false;
}

// Of each surface, front to back, the share of the location at the origin that is seen of it: of one that a triangle
// surrounds it with all that is left, of one too thin for that its samples' weight against that of a surface without
// gaps of `spp` samples a square pixel, of the last what is left.
inline std::vector<float> shares(std::span<const float> x, std::span<const float> y, std::span<const std::uint16_t> surface,
                                 size_t surfaces, float radius, float spp) {
    std::vector<float> share(surfaces, 0.0f);
    float left = 1;
    for (size_t k = 0; k < surfaces; ++k) {
        std::vector<float> own_x, own_y;
        float around = 0, weight = 0;
        for (size_t i = 0; i < x.size(); ++i) {
            if (surface[i] != k) continue;
            own_x.push_back(x[i]);
            own_y.push_back(y[i]);
            const float d = std::hypot(x[i], y[i]);
            if (d < 2 * radius) ++around;
            if (d < radius) weight += (1 - d / radius) * (1 - d / radius);
        }
        const float disk = 3.14159265f * radius * radius * spp;
        float covered = 1;
        if (k + 1 < surfaces) {
            if (around < thin_around * 4 * disk) covered = std::min(1.0f, weight / (squared_tent_mean * disk));
            else covered = surrounded(own_x, own_y, radius) ? 1.0f : 0.0f;
        }
        share[k] = left * covered;
        left -= share[k];
    }
    return share;
}

// Whether the origin lies in the convex hull: some segment across the horizontal line through it passes
// on its right, and some on its left.
inline bool hull_holds_origin(std::span<const float> x, std::span<const float> y) {
    bool left = false, right = false;
    for (size_t i = 0; i < x.size(); ++i)
        for (size_t j = 0; j < x.size(); ++j)
            if (y[i] >= 0 && y[j] < 0) {
                const float side = x[i] * y[j] - y[i] * x[j];  // of the origin, seen along j -> i
                left = left || side > 0;
                right = right || side < 0;
            }
    return left && right;
}

}  // namespace weft::light_field::reference
