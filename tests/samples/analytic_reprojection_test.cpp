// Samples of the garden, carried along their trajectories by coc and motion alone, land where the
// scene itself puts their surface points; and all the rest of what a buffer promises.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "samples/analytic_garden.h"
#include "samples/analytic_scene.h"
#include "samples/random.h"

namespace weft {
namespace {

using namespace analytic;

struct P2 {
    double x, y;
};

// light-field: to the lens centre, to the other time, to the other lens position.
P2 reprojected(const Samples& s, size_t i, double u, double v, double t) {
    const double c0 = double(s.lens->c0), c1 = double(s.lens->c1), z = double(s.z()[i]);
    const double c = c0 / z + c1;
    const double px = double(s.xy()[2 * i]) - c * double(s.uv()[2 * i]),
                 py = double(s.xy()[2 * i + 1]) - c * double(s.uv()[2 * i + 1]);
    const double dt = t - double(s.t()[i]);
    const double x = px * z + dt * double(s.motion()[3 * i]),
                 y = py * z + dt * double(s.motion()[3 * i + 1]),
                 w = z + dt * double(s.motion()[3 * i + 2]);
    return {x / w + (c0 / w + c1) * u, y / w + (c0 / w + c1) * v};
}

// The scene's own answer in double: the point moves by its share of the primitive's displacement,
// and is seen through that point of the lens on the plane in focus.
P2 projected(const Scene& scene, const Samples& s, size_t i, double u, double v, double t) {
    const Primitive& p = scene.primitives[s.find("id")->ids[i] - 1];
    const auto position = s.values("position").subspan(3 * i, 3);
    double a = 0, b = 0;
    if (!p.sphere()) {  // where on the patch, by least squares
        const double d = double(s.t()[i]) - 0.5;
        const auto at = [&](Vec3 v0, Vec3 v1, int k) {
            const float c0[3] = {v0.x, v0.y, v0.z}, c1[3] = {v1.x, v1.y, v1.z};
            return double(c0[k]) + d * double(c1[k]);
        };
        double aa = 0, ab = 0, bb = 0, ra = 0, rb = 0;
        for (int k = 0; k < 3; ++k) {
            const double sa = at(p.side_a, p.side_a_motion, k),
                         sb = at(p.side_b, p.side_b_motion, k);
            const double r = double(position[size_t(k)]) - at(p.origin, p.origin_motion, k);
            aa += sa * sa, ab += sa * sb, bb += sb * sb, ra += r * sa, rb += r * sb;
        }
        const double det = aa * bb - ab * ab;
        a = (ra * bb - rb * ab) / det, b = (rb * aa - ra * ab) / det;
    }
    const double dt = t - double(s.t()[i]);
    const auto moved = [&](float x, float m, float ma, float mb) {
        return double(x) + dt * (double(m) + a * double(ma) + b * double(mb));
    };
    const double x = moved(position[0], p.origin_motion.x, p.side_a_motion.x, p.side_b_motion.x);
    const double y = moved(position[1], p.origin_motion.y, p.side_a_motion.y, p.side_b_motion.y);
    const double z = moved(position[2], p.origin_motion.z, p.side_a_motion.z, p.side_b_motion.z);
    const Camera& c = scene.camera;
    const double lx = double(c.lens_radius) * u, ly = double(c.lens_radius) * v,
                 k = double(c.focus) / z;
    return {double(c.center_x) + double(c.scale) * (lx + (x - lx) * k) / double(c.focus),
            double(c.center_y) + double(c.scale) * (ly + (y - ly) * k) / double(c.focus)};
}

struct Case {
    AnalyticOptions options{.width = 320, .height = 180, .spp = 2};
    PlainContext ctx;
    Samples samples = analytic_samples("garden", options, ctx);
    Scene scene = garden_scene(options);
};

TEST(AnalyticReprojection, trajectories_are_exact) {
    Case garden;
    const Samples& s = garden.samples;
    double worst = 0, farthest = 0;
    size_t moving = 0, turning = 0;
    for (size_t i = 0; i < s.size(); ++i) {
        if (std::isinf(s.z()[i])) continue;
        const Disk lens = concentric_disk(unit_float(mix(3 * i)), unit_float(mix(3 * i + 1)));
        const double u = double(lens.u), v = double(lens.v), t = double(unit_float(mix(3 * i + 2)));
        const P2 a = reprojected(s, i, u, v, t), b = projected(garden.scene, s, i, u, v, t);
        worst = std::max(worst, std::hypot(a.x - b.x, a.y - b.y));
        farthest = std::max(
            farthest, std::hypot(a.x - double(s.xy()[2 * i]), a.y - double(s.xy()[2 * i + 1])));
        moving += s.motion()[3 * i] != 0;
        turning += garden.scene.primitives[s.find("id")->ids[i] - 1].turns();
    }
    EXPECT_LT(worst, 1e-3);
    EXPECT_GT(farthest, 20);  // pixels: there is something to be right about
    EXPECT_GT(moving, s.size() / 50);
    EXPECT_GT(turning, s.size() / 100);
}

TEST(AnalyticReprojection, the_sky_moves_over_the_lens_as_what_is_infinitely_far) {
    Case garden;
    const Samples& s = garden.samples;
    size_t sky = 0;
    for (size_t i = 0; i < s.size(); ++i) {
        if (!std::isinf(s.z()[i])) continue;
        ++sky;
        EXPECT_EQ(s.motion()[3 * i], 0);
        EXPECT_EQ(s.values("alpha")[i], 0);
        EXPECT_EQ(s.find("id")->ids[i], 0u);
        // Its direction seen from the centre, by C1 alone, has its radiance.
        const float x = s.xy()[2 * i] - s.lens->c1 * s.uv()[2 * i],
                    y = s.xy()[2 * i + 1] - s.lens->c1 * s.uv()[2 * i + 1];
        const Camera& c = garden.scene.camera;
        const Vec3 radiance =
            garden.scene.sky((x - c.center_x) / c.scale, (y - c.center_y) / c.scale);
        ASSERT_NEAR(s.rgb()[3 * i], radiance.x, 2e-2f * (1 + radiance.x));
    }
    EXPECT_GT(sky, s.size() / 10);
}

TEST(AnalyticReprojection, buffers_hold_what_the_format_promises) {
    Case garden;
    const Samples& s = garden.samples;
    EXPECT_EQ(s.size(), 320u * 180 * 2);
    EXPECT_LT(s.lens->c0, 0);
    EXPECT_GT(s.lens->c1, 0);
    EXPECT_NEAR(-s.lens->c0 / s.lens->c1, garden.scene.camera.focus, 1e-4);
    std::set<std::uint32_t> ids;
    for (size_t i = 0; i < s.size(); ++i) {
        const size_t pixel = i / 2;
        EXPECT_EQ(int(s.xy()[2 * i]), int(pixel % 320));
        EXPECT_EQ(int(s.xy()[2 * i + 1]), int(pixel / 320));
        EXPECT_LE(std::hypot(s.uv()[2 * i], s.uv()[2 * i + 1]), 1.00001f);
        EXPECT_TRUE(s.t()[i] >= 0 && s.t()[i] < 1);
        EXPECT_GT(s.z()[i], 0);
        for (size_t c = 0; c < 3; ++c)
            EXPECT_TRUE(std::isfinite(s.rgb()[3 * i + c]) && s.rgb()[3 * i + c] >= 0) << i;
        const auto n = s.values("normal").subspan(3 * i, 3);
        const float length = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        EXPECT_NEAR(length, std::isinf(s.z()[i]) ? 0 : 1, 1e-4);
        ids.insert(s.find("id")->ids[i]);
        // The whole of the shutter lies before the lens.
        if (!std::isinf(s.z()[i])) {
            EXPECT_GT(s.z()[i] - s.t()[i] * s.motion()[3 * i + 2], 0);
            EXPECT_GT(s.z()[i] + (1 - s.t()[i]) * s.motion()[3 * i + 2], 0);
        }
    }
    EXPECT_GT(ids.size(), 400u);  // many layers
}

// Bounds and early outs lose nothing: the same rays against every primitive.
TEST(AnalyticReprojection, tiles_hide_no_primitive) {
    const AnalyticOptions o{.width = 128, .height = 72, .spp = 4};
    const Scene scene = garden_scene(o);
    const Tracer tracer(scene, o.width, o.height);
    PlainContext ctx;
    const Samples s = analytic_samples("garden", o, ctx);
    const Camera& c = scene.camera;
    const auto rays = std::make_unique<Rays>();
    for (size_t first = 0; first < s.size(); first += Rays::capacity) {
        rays->count = int(std::min<size_t>(Rays::capacity, s.size() - first));
        for (int k = 0; k < rays->count; ++k) {
            const size_t i = first + size_t(k);
            const float u = s.uv()[2 * i], v = s.uv()[2 * i + 1], slope = c.lens_radius / c.focus;
            rays->lens_x[k] = c.lens_radius * u, rays->lens_y[k] = c.lens_radius * v;
            rays->x[k] = (s.xy()[2 * i] - c.center_x) * (1 / c.scale) - slope * u;
            rays->y[k] = (s.xy()[2 * i + 1] - c.center_y) * (1 / c.scale) - slope * v;
            rays->time[k] = s.t()[i] - 0.5f;
        }
        tracer.trace_all(*rays);
        for (int k = 0; k < rays->count; ++k)
            ASSERT_EQ(rays->depth[k], s.z()[first + size_t(k)]) << first + size_t(k);
    }
}

// The same bits whatever the pieces are run in.
TEST(AnalyticReprojection, pictures_do_not_depend_on_the_order_of_tiles) {
    struct Backwards : PlainContext {
        void parallel(size_t count, size_t grain,
                      const std::function<void(size_t, size_t)>& work) override {
            for (size_t begin = (count - 1) / grain * grain + grain; begin > 0; begin -= grain)
                work(begin - grain, std::min(count, begin));
        }
    } backwards;
    PlainContext forwards;
    const AnalyticOptions o{.width = 75, .height = 41, .spp = 5};
    const Image a = analytic_reference("garden", o, 20, forwards),
                b = analytic_reference("garden", o, 20, backwards);
    EXPECT_TRUE(std::equal(a.pixels().begin(), a.pixels().end(), b.pixels().begin()));
    const Samples sa = analytic_samples("garden", o, forwards),
                  sb = analytic_samples("garden", o, backwards);
    for (const Channel& channel : sa.channels) {
        const Channel* other = sb.find(channel.name);
        EXPECT_TRUE(std::equal(channel.values.view().begin(), channel.values.view().end(),
                               other->values.view().begin()))
            << channel.name;
        EXPECT_TRUE(std::equal(channel.ids.view().begin(), channel.ids.view().end(),
                               other->ids.view().begin()))
            << channel.name;
    }
}

}  // namespace
}  // namespace weft
