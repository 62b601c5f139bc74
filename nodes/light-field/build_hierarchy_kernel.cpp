#include "light-field/build_hierarchy_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "light-field/local_radius.h"
#include "light-field/pages_done.h"
#include "light-field/sample_order.h"

namespace weft::light_field {

float dispersion_radius(double samples_per_pixel) {
    return float(2.2 / std::sqrt(std::max(samples_per_pixel, 0.0) + 0.2));
}

Recentred recentred(const Places& places, const Lens& lens, size_t i) {
    Recentred r{};
    WEFT_PICK(recentre)(places.from(i), lens, 1, {&r.X, &r.Y, &r.W, &r.VX, &r.VY, &r.VW});
    return r;
}

Places places_of(const Samples& samples) {
    const auto start = [](std::span<const float> values) {
        return values.empty() ? nullptr : values.data();
    };
    Places from{start(samples.xy()), start(samples.z()), start(samples.uv()), nullptr, nullptr};
    if (samples.has_motion()) {
        from.t = samples.t().data();
        from.motion = samples.motion().data();
    }
    return from;
}

namespace {

KeyGrid key_grid(const Hierarchy& h, Arrangement arrangement) {
    KeyGrid grid;
    grid.layers = arrangement == Arrangement::layers;
    // Samples may lie outside the picture by what lens and motion move them; beyond this they share
    // blocks.
    grid.border = 0.25 * std::max(h.width, h.height);
    grid.cell = std::sqrt((grid.layers ? 48 : 16) / std::max(h.mean_spp, 1e-3));
    grid.cell = std::max(grid.cell, (std::max(h.width, h.height) + 2 * grid.border) / 32000.0);
    grid.columns = std::floor((h.width + 2 * grid.border) / grid.cell) + 1;
    grid.middle_x = 0.5 * h.width;
    grid.middle_y = 0.5 * h.height;
    grid.c0 = h.lens.c0;
    grid.c1 = h.lens.c1;
    return grid;
}

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
        const float W = h.W[i];
        const auto [VX, VY, VW] = h.velocity(i);
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
        const float W = h.W[i];
        const auto [VX, VY, VW] = h.velocity(i);
        const Range mx = drift(h.X[i], VX, W, VW, vx.middle());
        const Range my = drift(h.Y[i], VY, W, VW, vy.middle());
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
void allocate(Hierarchy& h, bool colored) {
    const size_t n = h.size(), count = (n + Hierarchy::group_size - 1) / Hierarchy::group_size;
    h.groups.moves.resize(count);
    h.levels.assign(1, {});
    resize(h.levels[0], count);
    Hierarchy::Groups& g = h.groups;
    for (auto* values : {&g.slope, &g.velocity_x, &g.velocity_y, &g.x_low, &g.x_high, &g.y_low,
                         &g.y_high, &g.slope_spread, &g.velocity_x_spread, &g.velocity_y_spread})
        values->resize(count);
    for (auto* values : {&h.X, &h.Y, &h.W}) values->resize(count * Hierarchy::group_size);
    if (h.moving) h.paths.resize(4 * count * Hierarchy::group_size);
    if (colored) h.rgba.resize(4 * n);
}

// What is known of the surfaces that a light sees.
void take_planes(const Samples& samples, Hierarchy& h, Context& ctx) {
    const auto gradient = samples.values("z_gradient"), end = samples.values("end"),
               bulge = samples.values("bulge"), z = samples.z();
    if (!gradient.empty()) h.plane_x.resize(h.size()), h.plane_y.resize(h.size());
    if (!end.empty()) h.end.resize(h.size());
    if (!bulge.empty()) h.bulge.resize(h.size());
    ctx.parallel(h.size(), 65536, [&](size_t begin, size_t last) {
        for (size_t i = begin; i < last; ++i) {
            const size_t from = h.order[i];
            if (!end.empty()) h.end[i] = end[from];
            if (!bulge.empty()) h.bulge[i] = bulge[from];
            if (gradient.empty()) continue;
            const float square = -1 / (z[from] * z[from]);
            h.plane_x[i] = gradient[2 * from] * square;
            h.plane_y[i] = gradient[2 * from + 1] * square;
        }
    });
}

void put_path(Hierarchy& h, size_t i, float VX, float VY, float VW) {
    float* to = &h.paths[4 * i];
    to[0] = h.W[i], to[1] = VX, to[2] = VY, to[3] = VW;
}

void place_nowhere(Hierarchy& h, size_t i) {
    h.X[i] = h.Y[i] = 0;
    h.W[i] = -1;
    if (h.moving) put_path(h, i, 0, 0, 0);
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

// Of what a light sees: the camera's samples a pixel. So dense they are where a pixel of the
// light's film is as large as one of the camera's; where not, locations say (Locations::ratio).
double camera_spp(const Samples& samples) {
    const Json* light = samples.meta.find("light");
    const Json* spp = light ? light->find("camera_spp") : nullptr;
    return spp && spp->is(Json::Kind::number) && spp->number > 0 ? spp->number : 1.0;
}

}  // namespace

Hierarchy build_hierarchy(const Samples& samples, Arrangement arrangement, double radius_scale,
                          Context& ctx) {
    // What a light sees has no colour of its own.
    const bool colored = samples.domain != "light";
    if (colored)
        samples.require("build-hierarchy", {"xy", "z", "rgb"});
    else
        samples.require("build-hierarchy", {"xy", "z"});
    const size_t n = samples.size();
    if (n > 0xfffffff0u)
        throw Error("the buffer has more than 4294967280 samples; reconstruct it in parts");
    Hierarchy h;
    h.width = samples.width;
    h.height = samples.height;
    h.mean_spp = colored ? samples.mean_spp() : camera_spp(samples);
    h.radius = float(radius_scale) * dispersion_radius(h.mean_spp);
    if (colored) h.radii = local_radii(samples, radius_scale, ctx);
    if (samples.has_lens()) h.lens = *samples.lens;
    h.shutter = shutter_of(samples.meta);
    h.moving = samples.has_motion();
    h.color_space = samples.color_space;
    if (const Channel* uv = samples.find("uv"); uv && samples.has_lens()) h.uv = uv->values;
    if (const Channel* t = samples.find("t"); t && samples.has_motion()) h.t = t->values;
    if (const Channel* source = samples.find("source"); source && !colored) h.source = source->ids;

    const Places places = places_of(samples);
    const KeyGrid grid = key_grid(h, arrangement);
    LargeArray<std::uint64_t> keys(n);
    ctx.parallel(n, 65536, [&](size_t begin, size_t end) {
        constexpr size_t chunk = Fetched::most;
        std::array<std::array<float, chunk>, 6> path;
        const Paths to{path[0].data(), path[1].data(),
                       path[2].data(), h.moving ? path[3].data() : nullptr,
                       path[4].data(), path[5].data()};
        for (size_t i = begin; i < end; i += chunk) {
            const size_t count = std::min(chunk, end - i);
            WEFT_PICK(recentre)(places.from(i), h.lens, count, to);
            WEFT_PICK(sort_keys)(to, grid, count, &keys[i]);
        }
    });
    h.order = sorted(std::move(keys), ctx);
    allocate(h, colored);
    const auto rgb = samples.rgb(), alpha = samples.values("alpha");
    h.opaque = std::all_of(alpha.begin(), alpha.end(), [](float a) { return a == 1; });
    // Each sample is fetched once, and its group bounded while it is at hand.
    constexpr size_t chunk = Fetched::most, groups = chunk / Hierarchy::group_size;
    PagesDone pages(samples);
    ctx.parallel(h.groups.size(), groups * 16, [&](size_t first, size_t last) {
        Fetched fetched;
        std::array<std::array<float, chunk>, 3> velocity;
        auto& [VX, VY, VW] = velocity;
        for (size_t g = first; g < last; g += groups) {
            const size_t begin = g * Hierarchy::group_size,
                         end = std::min({begin + chunk, last * Hierarchy::group_size, n});
            fetched.fetch(places, std::span(h.order).subspan(begin, end - begin));
            WEFT_PICK(recentre)
            (fetched.places(places), h.lens, end - begin,
             {&h.X[begin], &h.Y[begin], &h.W[begin], h.moving ? VX.data() : nullptr, VY.data(),
              VW.data()});
            for (size_t i = begin; i < end && colored; ++i) {
                const size_t from = h.order[i];
                for (size_t c = 0; c < 3; ++c) h.rgba[4 * i + c] = rgb[3 * from + c];
                h.rgba[4 * i + 3] = alpha.empty() ? 1.0f : alpha[from];
            }
            for (size_t i = begin; i < end && h.moving; ++i)
                put_path(h, i, VX[i - begin], VY[i - begin], VW[i - begin]);
            for (size_t i = end; i % Hierarchy::group_size; ++i) place_nowhere(h, i);
            for (size_t bounded = g; bounded < std::min(g + groups, last); ++bounded)
                bound_group(h, bounded);
            pages.done(std::span(h.order).subspan(begin, end - begin));
        }
    });
    build_levels(h);
    if (!colored) take_planes(samples, h, ctx);
    return h;
}

}  // namespace weft::light_field
