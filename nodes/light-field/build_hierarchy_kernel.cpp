#include "light-field/build_hierarchy_kernel.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "light-field/local_radius.h"
#include "light-field/sample_order.h"

namespace weft::light_field {

float dispersion_radius(double samples_per_pixel) {
    return float(2.2 / std::sqrt(std::max(samples_per_pixel, 0.0) + 0.2));
}

Recentring::Recentring(const Samples& samples)
    : xy(samples.xy()),
      uv(samples.uv()),
      t(samples.t()),
      z(samples.z()),
      motion(samples.motion()),
      lens(samples.lens.value_or(Lens{})) {
    if (!samples.has_motion()) motion = {};
}

Recentred Recentring::operator()(size_t i) const {
    const bool far = std::isinf(z[i]);
    const float c = far ? lens.c1 : lens.c0 / z[i] + lens.c1;
    const float px = xy[2 * i] - (uv.empty() ? 0.0f : c * lens.aspect * uv[2 * i]);
    const float py = xy[2 * i + 1] - (uv.empty() ? 0.0f : c * uv[2 * i + 1]);
    const float w = far ? 1.0f : z[i];
    Recentred r{px * w, py * w, w, 0, 0, 0};
    if (!motion.empty()) {
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

Recentred recentred(const Samples& samples, size_t i) {
    return Recentring(samples)(i);
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

// The whole part of a value, within [0, most].
std::uint64_t clamped(double value, int most) {
    return value > 0 ? std::uint64_t(int(std::min(value, double(most)))) : 0;
}

// Where each sample goes: block of the picture, then slope and velocity, then place in the block.
class Keys {
  public:
    Keys(const Hierarchy& hierarchy, Arrangement by) : h(hierarchy), arrangement(by) {
        const double wanted = arrangement == Arrangement::layers ? 48 : 16;
        cell = std::sqrt(wanted / std::max(h.mean_spp, 1e-3));
        cell = std::max(cell, (std::max(h.width, h.height) + 2 * border()) / 32000.0);
        columns = int((h.width + 2 * border()) / cell) + 1;
    }

    std::uint64_t operator()(const Recentred& r) const {
        const bool there = r.W > 0;
        const double w = there ? r.W : 1.0;
        const double px = there ? r.X / w : 0.5 * h.width, py = there ? r.Y / w : 0.5 * h.height;
        const double x = (px + border()) / cell, y = (py + border()) / cell;
        const auto column = clamped(x, columns), row = clamped(y, 32767);
        if (arrangement == Arrangement::cells) return row * std::uint64_t(columns + 1) + column;
        const double slope = h.lens.c0 / w;
        const double vx = h.moving ? (r.VX - px * r.VW) / w : 0.0;
        const double vy = h.moving ? (r.VY - py * r.VW) / w : 0.0;
        // Steps small against what separates surfaces, so that groups are tight.
        const std::uint64_t slope_bits = clamped(128 + slope + h.lens.c1, 255);
        const std::uint64_t vx_bits = clamped(8 + vx / 3 + 0.5, 15),
                            vy_bits = clamped(8 + vy / 3 + 0.5, 15);
        const std::uint64_t fine = spread_bits(clamped(8 * (x - double(column)), 7)) |
                                   spread_bits(clamped(8 * (y - double(row)), 7)) << 1;
        const std::uint64_t block = spread_bits(column) | spread_bits(row) << 1;
        return (((block << 8 | slope_bits) << 4 | vx_bits) << 4 | vy_bits) << 6 | fine;
    }

  private:
    // Samples may lie outside the picture by what lens and motion move them; beyond this they share
    // blocks.
    double border() const { return 0.25 * std::max(h.width, h.height); }

    const Hierarchy& h;
    Arrangement arrangement;
    double cell = 1;
    int columns = 1;
};

}  // namespace

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
    const size_t begin = g * Hierarchy::group_size,
                 end = std::min(begin + Hierarchy::group_size, h.size());
    const float c0 = h.lens.c0, c1 = h.lens.c1;
    Range slope, vx, vy;
    std::uint8_t moves = 0;
    bool bounded = true;
    for (size_t i = begin; i < end; ++i) {
        const float W = h.W[i], VW = h.moving ? h.VW[i] : 0.0f;
        const float VX = h.moving ? h.VX[i] : 0.0f, VY = h.moving ? h.VY[i] : 0.0f;
        if (VW != 0)
            moves = 2;
        else if (VX != 0 || VY != 0)
            moves = std::max<std::uint8_t>(moves, 1);
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
        for (float d : {-0.5f, 0.5f})
            far = std::max(far, std::abs(c0 / (W + d * VW) + c1 - slope.middle()));
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
    for (auto* values : {&rects.x_low, &rects.x_high, &rects.y_low, &rects.y_high})
        values->resize(n);
}

// Room for all samples and groups.
void allocate(Hierarchy& h) {
    const size_t n = h.size(), count = (n + Hierarchy::group_size - 1) / Hierarchy::group_size;
    h.groups.moves.resize(count);
    h.levels.assign(1, {});
    resize(h.levels[0], count);
    Hierarchy::Groups& g = h.groups;
    for (auto* values : {&g.slope, &g.velocity_x, &g.velocity_y, &g.x_low, &g.x_high, &g.y_low,
                         &g.y_high, &g.slope_spread, &g.velocity_x_spread, &g.velocity_y_spread})
        values->resize(count);
    for (auto* values : {&h.X, &h.Y, &h.W}) values->resize(count * Hierarchy::group_size);
    if (h.moving)
        for (auto* values : {&h.VX, &h.VY, &h.VW}) values->resize(count * Hierarchy::group_size);
    h.rgba.resize(4 * n);
}

void place(Hierarchy& h, size_t i, const Recentred& r) {
    h.X[i] = r.X;
    h.Y[i] = r.Y;
    h.W[i] = r.W;
    if (!h.moving) return;
    h.VX[i] = r.VX;
    h.VY[i] = r.VY;
    h.VW[i] = r.VW;
}

void build_levels(Hierarchy& h) {
    while (h.levels.back().size() > Hierarchy::fan_out) {
        const auto& below = h.levels.back();
        Hierarchy::Rects above;
        resize(above, (below.size() + Hierarchy::fan_out - 1) / Hierarchy::fan_out);
        for (size_t i = 0; i < above.size(); ++i) {
            const size_t begin = i * Hierarchy::fan_out,
                         end = std::min(begin + Hierarchy::fan_out, below.size());
            above.x_low[i] = *std::min_element(&below.x_low[begin], below.x_low.data() + end);
            above.x_high[i] = *std::max_element(&below.x_high[begin], below.x_high.data() + end);
            above.y_low[i] = *std::min_element(&below.y_low[begin], below.y_low.data() + end);
            above.y_high[i] = *std::max_element(&below.y_high[begin], below.y_high.data() + end);
        }
        h.levels.push_back(std::move(above));
    }
}

}  // namespace

Hierarchy build_hierarchy(const Samples& samples, Arrangement arrangement, double radius_scale,
                          Context& ctx) {
    samples.require("build-hierarchy", {"xy", "z", "rgb"});
    const size_t n = samples.size();
    if (n > 0xfffffff0u)
        throw Error("the buffer has more than 4294967280 samples; reconstruct it in parts");
    Hierarchy h;
    h.width = samples.width;
    h.height = samples.height;
    h.mean_spp = samples.mean_spp();
    h.radius = float(radius_scale) * dispersion_radius(samples.mean_spp());
    h.radii = local_radii(samples, radius_scale, ctx);
    if (samples.has_lens()) h.lens = *samples.lens;
    h.shutter = shutter_of(samples.meta);
    h.moving = samples.has_motion();
    h.color_space = samples.color_space;

    const Recentring recentred(samples);
    LargeArray<std::uint64_t> keys(n);
    const Keys key_of(h, arrangement);
    ctx.parallel_for(
        n, [&](size_t i) { keys[i] = key_of(recentred(i)); }, 4096);
    h.order = sorted(std::move(keys), ctx);
    allocate(h);
    const auto rgb = samples.rgb(), alpha = samples.values("alpha");
    const size_t groups = h.groups.size();
    constexpr size_t ahead = 48;
    // Each sample is fetched once, and its group bounded while it is at hand.
    ctx.parallel_for(
        groups,
        [&](size_t g) {
            const size_t begin = g * Hierarchy::group_size,
                         end = std::min(begin + Hierarchy::group_size, n);
            for (size_t i = begin; i < end; ++i) {
                if (const size_t later = i + ahead; later < n) {
                    recentred.prefetch(h.order[later]);
                    __builtin_prefetch(&rgb[3 * size_t(h.order[later])]);
                }
                const size_t from = h.order[i];
                place(h, i, recentred(from));
                for (size_t c = 0; c < 3; ++c) h.rgba[4 * i + c] = rgb[3 * from + c];
                h.rgba[4 * i + 3] = alpha.empty() ? 1.0f : alpha[from];
            }
            for (size_t i = end; i < begin + Hierarchy::group_size; ++i)
                place(h, i, {0, 0, -1, 0, 0, 0});
            bound_group(h, g);
        },
        256);
    build_levels(h);
    return h;
}

}  // namespace weft::light_field
