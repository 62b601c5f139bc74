#include "light-field/build_hierarchy_kernel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace weft::light_field {

float dispersion_radius(double samples_per_pixel) {
    return float(2.2 / std::sqrt(std::max(samples_per_pixel, 0.0) + 0.2));
}

Recentred recentred(const Samples& samples, size_t i) {
    const auto xy = samples.xy(), uv = samples.uv(), t = samples.t(), z = samples.z(), motion = samples.motion();
    const Lens lens = samples.lens.value_or(Lens{});
    const bool far = std::isinf(z[i]);
    const float c = far ? lens.c1 : lens.c0 / z[i] + lens.c1;
    const float px = xy[2 * i] - (uv.empty() ? 0.0f : c * lens.aspect * uv[2 * i]);
    const float py = xy[2 * i + 1] - (uv.empty() ? 0.0f : c * uv[2 * i + 1]);
    const float w = far ? 1.0f : z[i];
    Recentred r{px * w, py * w, w, 0, 0, 0};
    if (samples.has_motion()) {
        r.VX = motion[3 * i];
        r.VY = motion[3 * i + 1];
        r.VW = motion[3 * i + 2];
        const float d = 0.5f - t[i];
        r.X += d * r.VX;
        r.Y += d * r.VY;
        r.W += d * r.VW;
    }
    if (far)
        for (float* value : {&r.X, &r.Y, &r.W, &r.VX, &r.VY, &r.VW}) *value *= far_depth;
    return r;
}

namespace {

// The bits of x, each followed by a zero.
std::uint64_t spread_bits(std::uint64_t x) {
    x &= 0xffffffff;
    x = (x | x << 16) & 0x0000ffff0000ffffull;
    x = (x | x << 8) & 0x00ff00ff00ff00ffull;
    x = (x | x << 4) & 0x0f0f0f0f0f0f0f0full;
    x = (x | x << 2) & 0x3333333333333333ull;
    return (x | x << 1) & 0x5555555555555555ull;
}

std::uint64_t clamped(double value, std::uint64_t most) {
    return value > 0 ? std::min(std::uint64_t(std::min(value, 1e15)), most) : 0;
}

// Positions in units of `cell`, from the frame's corner, kept within a frame's width of it.
struct Place {
    double x, y;
};

}  // namespace

std::vector<std::uint64_t> sort_keys(const Hierarchy& h, Arrangement arrangement, Context& ctx) {
    const size_t n = h.W.size();
    std::vector<std::uint64_t> keys(n);
    const double border = 0.25 * std::max(h.width, h.height);
    const double wanted = arrangement == Arrangement::layers ? 48 : 16;
    double cell = std::sqrt(wanted / std::max(h.mean_spp, 1e-3));
    cell = std::max(cell, (std::max(h.width, h.height) + 2 * border) / 32000.0);
    const auto columns = std::uint64_t((h.width + 2 * border) / cell) + 1;
    ctx.parallel_for(
        n,
        [&](size_t i) {
            const bool there = h.W[i] > 0;
            const double w = there ? h.W[i] : 1.0;
            const double px = there ? h.X[i] / w : 0.5 * h.width, py = there ? h.Y[i] / w : 0.5 * h.height;
            const double x = (px + border) / cell, y = (py + border) / cell;
            const auto column = clamped(x, columns), row = clamped(y, 32767);
            if (arrangement == Arrangement::cells) {
                keys[i] = row * (columns + 1) + column;
                return;
            }
            const double slope = h.lens.c0 / w;
            const double vx = h.moving ? (h.VX[i] - px * h.VW[i]) / w : 0.0;
            const double vy = h.moving ? (h.VY[i] - py * h.VW[i]) / w : 0.0;
            // Steps small against what separates surfaces, so that groups are tight.
            const std::uint64_t slope_bits = clamped(128 + slope + h.lens.c1, 255);
            const std::uint64_t vx_bits = clamped(8 + vx / 3 + 0.5, 15), vy_bits = clamped(8 + vy / 3 + 0.5, 15);
            const std::uint64_t fine = spread_bits(clamped(8 * (x - double(column)), 7)) |
                                       spread_bits(clamped(8 * (y - double(row)), 7)) << 1;
            const std::uint64_t block = spread_bits(column) | spread_bits(row) << 1;
            keys[i] = (((block << 8 | slope_bits) << 4 | vx_bits) << 4 | vy_bits) << 6 | fine;
        },
        4096);
    return keys;
}

std::vector<std::uint32_t> sorted(std::vector<std::uint64_t>& keys, Context& ctx) {
    const size_t n = keys.size();
    std::vector<std::uint32_t> order(n), other(n);
    std::iota(order.begin(), order.end(), 0u);
    std::vector<std::uint64_t> other_keys(n);
    std::uint64_t differ = 0;
    for (std::uint64_t key : keys) differ |= key ^ keys[0];
    constexpr int digit = 11;
    constexpr size_t radix = size_t(1) << digit;
    const size_t grain = std::max<size_t>(65536, (n + 63) / 64);
    const size_t pieces = (n + grain - 1) / grain;
    std::vector<std::array<std::uint32_t, radix>> counts(pieces);
    for (int shift = 0; shift < 64; shift += digit) {
        if (!(differ >> shift & (radix - 1))) continue;
        ctx.parallel(n, grain, [&](size_t begin, size_t end) {
            auto& count = counts[begin / grain];
            count.fill(0);
            for (size_t i = begin; i < end; ++i) ++count[keys[i] >> shift & (radix - 1)];
        });
        std::uint32_t sum = 0;
        for (size_t d = 0; d < radix; ++d)
            for (auto& count : counts) sum += std::exchange(count[d], sum);
        ctx.parallel(n, grain, [&](size_t begin, size_t end) {
            auto& place = counts[begin / grain];
            for (size_t i = begin; i < end; ++i) {
                const std::uint32_t to = place[keys[i] >> shift & (radix - 1)]++;
                other_keys[to] = keys[i];
                other[to] = order[i];
            }
        });
        keys.swap(other_keys);
        order.swap(other);
    }
    return order;
}

namespace {

// Range of one value.
struct Range {
    float low = 1e30f, high = -1e30f;
    void add(float value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    float middle() const { return 0.5f * (low + high); }
    float half() const { return 0.5f * (high - low); }
};

constexpr float everywhere = 1e30f;
// Rounding of positions of a few thousand pixels, and to spare.
constexpr float slack = 2e-3f;

// What x(d) - velocity d reaches over the shutter, with x(d) = (P + d V) / (W + d VW).
Range drift(float P, float V, float W, float VW, float velocity) {
    Range range;
    const auto at = [&](float d) { range.add((P + d * V) / (W + d * VW) - velocity * d); };
    at(-0.5f);
    at(0.5f);
    // Where x'(d) = (V W - P VW) / (W + d VW)^2 equals the velocity.
    const float ratio = (V * W - P * VW) / velocity;
    if (VW != 0 && ratio > 0) {
        const float d = (std::sqrt(ratio) - W) / VW;
        if (d > -0.5f && d < 0.5f) at(d);
    }
    return range;
}

void bound_group(Hierarchy& h, size_t g) {
    auto& out = h.groups;
    auto& rect = h.levels[0];
    const size_t begin = g * Hierarchy::group_size, end = std::min(begin + Hierarchy::group_size, h.size());
    const float c0 = h.lens.c0, c1 = h.lens.c1;
    Range slope, vx, vy;
    std::uint8_t moves = 0;
    bool bounded = true;
    for (size_t i = begin; i < end; ++i) {
        const float W = h.W[i], VW = h.moving ? h.VW[i] : 0.0f;
        const float VX = h.moving ? h.VX[i] : 0.0f, VY = h.moving ? h.VY[i] : 0.0f;
        if (VW != 0) moves = 2;
        else if (VX != 0 || VY != 0) moves = std::max<std::uint8_t>(moves, 1);
        if (!always_there(W, VW)) {
            bounded = false;
            continue;
        }
        for (float d : {-0.5f, 0.5f}) {
            const float w = W + d * VW;
            slope.add(c0 / w + c1);
            for (float lens : {-1.0f, 1.0f}) {
                vx.add((VX - VW * (h.X[i] + d * VX + c0 * h.lens.aspect * lens) / w) / w);
                vy.add((VY - VW * (h.Y[i] + d * VY + c0 * lens) / w) / w);
            }
        }
    }
    if (slope.high < slope.low) slope = vx = vy = {0, 0};
    Range x, y;
    for (size_t i = begin; i < end && bounded; ++i) {
        const float W = h.W[i], VW = h.moving ? h.VW[i] : 0.0f;
        const Range mx = drift(h.X[i], h.moving ? h.VX[i] : 0.0f, W, VW, vx.middle());
        const Range my = drift(h.Y[i], h.moving ? h.VY[i] : 0.0f, W, VW, vy.middle());
        float far = 0;
        for (float d : {-0.5f, 0.5f}) far = std::max(far, std::abs(c0 / (W + d * VW) + c1 - slope.middle()));
        x.add(mx.low - far * h.lens.aspect);
        x.add(mx.high + far * h.lens.aspect);
        y.add(my.low - far);
        y.add(my.high + far);
    }
    if (!bounded) x = y = {-everywhere, everywhere};
    out.slope[g] = bounded ? slope.middle() : 0.0f;
    out.velocity_x[g] = bounded ? vx.middle() : 0.0f;
    out.velocity_y[g] = bounded ? vy.middle() : 0.0f;
    out.slope_spread[g] = bounded ? slope.half() : everywhere;
    out.velocity_x_spread[g] = bounded ? vx.half() : everywhere;
    out.velocity_y_spread[g] = bounded ? vy.half() : everywhere;
    out.x_low[g] = x.low - slack;
    out.x_high[g] = x.high + slack;
    out.y_low[g] = y.low - slack;
    out.y_high[g] = y.high + slack;
    out.moves[g] = moves;
    const float blur = std::abs(out.slope[g]);
    const float grow_x = blur * h.lens.aspect + 0.5f * std::abs(out.velocity_x[g]);
    const float grow_y = blur + 0.5f * std::abs(out.velocity_y[g]);
    rect.x_low[g] = out.x_low[g] - grow_x;
    rect.x_high[g] = out.x_high[g] + grow_x;
    rect.y_low[g] = out.y_low[g] - grow_y;
    rect.y_high[g] = out.y_high[g] + grow_y;
}

void resize(Hierarchy::Rects& rects, size_t n) {
    for (auto* values : {&rects.x_low, &rects.x_high, &rects.y_low, &rects.y_high}) values->resize(n);
}

}  // namespace

void bound(Hierarchy& h, Context& ctx) {
    const size_t groups = h.W.size() / Hierarchy::group_size;
    auto& out = h.groups;
    for (auto* values : {&out.slope, &out.velocity_x, &out.velocity_y, &out.x_low, &out.x_high, &out.y_low,
                         &out.y_high, &out.slope_spread, &out.velocity_x_spread, &out.velocity_y_spread})
        values->resize(groups);
    out.moves.resize(groups);
    h.levels.assign(1, {});
    resize(h.levels[0], groups);
    ctx.parallel_for(groups, [&](size_t g) { bound_group(h, g); }, 1024);
    while (h.levels.back().size() > Hierarchy::fan_out) {
        const auto& below = h.levels.back();
        Hierarchy::Rects above;
        resize(above, (below.size() + Hierarchy::fan_out - 1) / Hierarchy::fan_out);
        for (size_t i = 0; i < above.size(); ++i) {
            const size_t begin = i * Hierarchy::fan_out, end = std::min(begin + Hierarchy::fan_out, below.size());
            above.x_low[i] = *std::min_element(&below.x_low[begin], below.x_low.data() + end);
            above.x_high[i] = *std::max_element(&below.x_high[begin], below.x_high.data() + end);
            above.y_low[i] = *std::min_element(&below.y_low[begin], below.y_low.data() + end);
            above.y_high[i] = *std::max_element(&below.y_high[begin], below.y_high.data() + end);
        }
        h.levels.push_back(std::move(above));
    }
}

Hierarchy build_hierarchy(const Samples& samples, Arrangement arrangement, double radius_scale, Context& ctx) {
    samples.require("build-hierarchy", {"xy", "z", "rgb"});
    const size_t n = samples.size();
    if (n > 0xfffffff0u) throw Error("the buffer has more than 4294967280 samples; reconstruct it in parts");
    Hierarchy unsorted;
    unsorted.width = samples.width;
    unsorted.height = samples.height;
    unsorted.mean_spp = samples.mean_spp();
    unsorted.radius = float(radius_scale) * dispersion_radius(samples.mean_spp());
    if (samples.has_lens()) unsorted.lens = *samples.lens;
    unsorted.moving = samples.has_motion();
    std::vector<std::uint32_t> order;
    {
        for (auto* values : {&unsorted.X, &unsorted.Y, &unsorted.W}) values->resize(n);
        if (unsorted.moving)
            for (auto* values : {&unsorted.VX, &unsorted.VY, &unsorted.VW}) values->resize(n);
        ctx.parallel_for(
            n,
            [&](size_t i) {
                const Recentred r = recentred(samples, i);
                unsorted.X[i] = r.X;
                unsorted.Y[i] = r.Y;
                unsorted.W[i] = r.W;
                if (!unsorted.moving) return;
                unsorted.VX[i] = r.VX;
                unsorted.VY[i] = r.VY;
                unsorted.VW[i] = r.VW;
            },
            4096);
        auto keys = sort_keys(unsorted, arrangement, ctx);
        order = sorted(keys, ctx);
    }
    Hierarchy h;
    h.width = unsorted.width;
    h.height = unsorted.height;
    h.mean_spp = unsorted.mean_spp;
    h.radius = unsorted.radius;
    h.lens = unsorted.lens;
    h.shutter = shutter_of(samples.meta);
    h.moving = unsorted.moving;
    h.color_space = samples.color_space;
    const size_t filled = (n + Hierarchy::group_size - 1) / Hierarchy::group_size * Hierarchy::group_size;
    const auto take = [&](std::vector<float>& from, std::vector<float>& to, float filling) {
        if (from.empty() && n > 0) return;
        to.assign(filled, filling);
        ctx.parallel_for(n, [&](size_t i) { to[i] = from[order[i]]; }, 4096);
        from = {};
    };
    take(unsorted.X, h.X, 0);
    take(unsorted.Y, h.Y, 0);
    take(unsorted.W, h.W, -1);
    take(unsorted.VX, h.VX, 0);
    take(unsorted.VY, h.VY, 0);
    take(unsorted.VW, h.VW, 0);
    const auto rgb = samples.rgb(), alpha = samples.values("alpha");
    h.rgba.resize(4 * n);
    ctx.parallel_for(
        n,
        [&](size_t i) {
            for (size_t c = 0; c < 3; ++c) h.rgba[4 * i + c] = rgb[3 * size_t(order[i]) + c];
            h.rgba[4 * i + 3] = alpha.empty() ? 1.0f : alpha[order[i]];
        },
        4096);
    h.order = std::move(order);
    bound(h, ctx);
    return h;
}

}  // namespace weft::light_field
