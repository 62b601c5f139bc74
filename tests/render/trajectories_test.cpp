// Depth, circle of confusion and motion: a sample carried along its trajectory lands where its
// surface point is seen from the other lens position at the other time, found by tracing again.
#include "render/render_test.h"
#include "render/surface.h"
#include "samples/random.h"

namespace weft::render {
namespace {

struct P2 {
    double x, y;
};

// light-field: to the lens centre, to the other time, to the other lens position.
P2 carried(const Samples& s, size_t i, double u, double v, double t) {
    const Lens lens = s.lens.value_or(Lens{});
    const auto c = [&](double z) { return double(lens.c0) / z + double(lens.c1); };
    const double z = double(s.z()[i]), a = double(lens.aspect), dt = t - double(s.t()[i]);
    const double px = double(s.xy()[2 * i]) - c(z) * a * double(s.uv()[2 * i]);
    const double py = double(s.xy()[2 * i + 1]) - c(z) * double(s.uv()[2 * i + 1]);
    const double w = z + dt * double(s.motion()[3 * i + 2]);
    return {(px * z + dt * double(s.motion()[3 * i])) / w + c(w) * a * u,
            (py * z + dt * double(s.motion()[3 * i + 1])) / w + c(w) * v};
}

Scene moving_scene(bool turning) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {floor_mesh(20), ball_mesh(24, true), ball_mesh(12, false)};
    // A ball that is pushed out of shape: vertices on straight lines.
    Mesh& bent = scene.meshes[2];
    bent.steps = 2;
    const std::vector<Vec3> start = bent.positions;
    for (const Vec3 p : start)
        bent.positions.push_back({p.x * 1.3f + 0.2f * p.y, p.y * 0.8f, p.z + 0.5f});
    const auto at = [](Vec3 p) { return translate(p) * scale(0.6f); };
    scene.instances = {
        placed(0, {translate({0, -1, 0})}, 1),
        placed(1, {at({-1.5f, 0, 0}), at({-0.8f, 0.3f, 1.5f})}, 2), placed(2, {at({1, 0, -1})}, 3),
        // Grows and leans as it goes: affine, not rigid.
        placed(1,
               {at({0, 0.8f, -2}),
                translate({0.5f, 1, -1}) * Affine{{0.9f, 0, 0}, {0.2f, 0.7f, 0}, {0, 0, 0.5f}, {}}},
               4)};
    if (turning)
        scene.instances.push_back(placed(
            2, moving(translate({0, -0.2f, 1}) * scale(0.4f), {0.3f, 0, 0}, {0, 0, 1}, 2.5f), 5));
    scene.environment.radiance = {1, 1, 1};
    scene.camera = camera_at({0, 1, 6}, {0, 0, 0}, 40);
    scene.camera.lens_radius = 0.2f;
    scene.camera.focus = 5;
    return scene;
}

RenderOptions options() {
    RenderOptions o;
    o.width = 160, o.height = 90;
    o.max_depth = 0;
    return o;
}

struct Worst {
    double pixels = 0, farthest = 0;
    size_t checked = 0;
};
// Over all samples of objects with `id` below `ids`.
Worst check_trajectories(const Scene& scene, std::uint32_t ids, bool only_ends = false) {
    const RenderOptions o = options();
    const Samples s = render_scene(scene, o, 2, {"basic", "id", "uv", "t", "motion"});
    PlainContext ctx;
    const RayScene rays(scene, ctx);
    const Camera camera(scene.camera, o.width, o.height);
    Rays ray;
    ray.resize(1);
    const auto trace = [&](double x, double y, double u, double v, double t) {
        const Camera::Ray r = camera.ray(float(x), float(y), float(u), float(v), float(t));
        ray.set(0, r.origin, r.direction, 0, 1e30f, float(t), every_mask);
        rays.intersect(ray, 0, 1);
    };
    Worst worst;
    for (size_t i = 0; i < s.size(); ++i) {
        if (std::isinf(s.z()[i]) || s.find("id")->ids[i] >= ids) continue;
        trace(double(s.xy()[2 * i]), double(s.xy()[2 * i + 1]), double(s.uv()[2 * i]),
              double(s.uv()[2 * i + 1]), double(s.t()[i]));
        const std::uint32_t object = ray.object[0], primitive = ray.primitive[0];
        const float bu = ray.u[0], bv = ray.v[0];
        const Disk lens = concentric_disk(unit_float(mix(3 * i)), unit_float(mix(3 * i + 1)));
        double t = double(unit_float(mix(3 * i + 2)));
        if (only_ends) t = t < 0.5 ? 0 : 1;
        P2 there = carried(s, i, double(lens.u), double(lens.v), t);
        if (only_ends) {  // from the line's own place, so that the start's distance from it does
                          // not count
            const Vec3 begin = camera.homogeneous(
                camera.to_camera(position_at(rays.objects()[object], primitive, bu, bv, 0), 0));
            const Vec3 m{s.motion()[3 * i], s.motion()[3 * i + 1], s.motion()[3 * i + 2]};
            const Vec3 p = begin + m * float(t);
            const double c = double(s.lens->c0) / double(p.z) + double(s.lens->c1);
            there = {double(p.x / p.z) + c * double(lens.u),
                     double(p.y / p.z) + c * double(lens.v)};
        }
        const Vec3 truth = position_at(rays.objects()[object], primitive, bu, bv, float(t));
        trace(there.x, there.y, double(lens.u), double(lens.v), t);
        // Hidden from there, or seen past an edge: nothing to compare with.
        if (ray.object[0] != object || ray.primitive[0] != primitive) continue;
        const Vec3 found =
            position_at(rays.objects()[object], primitive, ray.u[0], ray.v[0], float(t));
        const Vec3 a = camera.homogeneous(camera.to_camera(truth, float(t))),
                   b = camera.homogeneous(camera.to_camera(found, float(t)));
        worst.pixels = std::max(worst.pixels,
                                double(std::hypot(a.x / a.z - b.x / b.z, a.y / a.z - b.y / b.z)));
        worst.farthest = std::max(worst.farthest, std::hypot(there.x - double(s.xy()[2 * i]),
                                                             there.y - double(s.xy()[2 * i + 1])));
        ++worst.checked;
    }
    return worst;
}

TEST(Trajectories, land_on_the_same_point_traced_again) {
    const Worst w = check_trajectories(moving_scene(false), 100);
    EXPECT_LT(w.pixels, 0.01);
    EXPECT_GT(w.farthest, 10);
    EXPECT_GT(w.checked, 10000u);
}

TEST(Trajectories, hold_for_an_anamorphic_lens_with_blades) {
    Scene scene = moving_scene(false);
    scene.camera.lens_aspect = 1.6f;
    scene.camera.blades = 6;
    scene.camera.blade_rotation = 0.3f;
    const Worst w = check_trajectories(scene, 100);
    EXPECT_LT(w.pixels, 0.01);
    EXPECT_GT(w.checked, 10000u);
}

TEST(Trajectories, hold_for_a_camera_that_moves_along) {
    Scene scene = moving_scene(false);
    Affine end = scene.camera.to_world[0];
    end.origin = end.origin + Vec3{0.4f, 0.1f, -0.5f};
    scene.camera.to_world.push_back(end);
    for (Instance& i : scene.instances) i.to_world.resize(1);
    const Worst w = check_trajectories(scene, 100);
    EXPECT_LT(w.pixels, 0.01);
    EXPECT_GT(w.checked, 8000u);
}

TEST(Trajectories, of_turning_things_are_exact_at_both_ends_and_the_rest_is_reported) {
    const Scene scene = moving_scene(true);
    EXPECT_LT(check_trajectories(scene, 5).pixels, 0.01);
    EXPECT_LT(check_trajectories(scene, 100, true).pixels, 0.01);
    float deviation = 0, none = 0;
    render_scene(scene, options(), 2, {"basic"}, nullptr, &deviation);
    EXPECT_GT(deviation, 1);
    EXPECT_LT(deviation, 40);
    render_scene(moving_scene(false), options(), 2, {"basic"}, nullptr, &none);
    EXPECT_LT(none, 0.01f);
}

TEST(Trajectories, the_sky_turns_with_the_camera) {
    Scene scene = moving_scene(false);
    scene.instances.clear();
    scene.camera.to_world = moving(scene.camera.to_world[0], {}, {0, 1, 0}, radians(3));
    const Samples s = render_scene(scene, options(), 1, {"basic", "t", "motion"});
    const double scale = 45 / std::tan(double(radians(20)));
    for (size_t i = 0; i < s.size(); i += 97) {
        ASSERT_TRUE(std::isinf(s.z()[i]));
        ASSERT_EQ(s.values("alpha")[i], 0);
        // At the middle of the picture 3 degrees are scale tan(3) pixels, about.
        if (std::fabs(s.xy()[2 * i] - 80) >= 8) continue;
        EXPECT_NEAR(std::fabs(s.motion()[3 * i]), scale * double(radians(3)), 1);
    }
}

TEST(Trajectories, depth_gradients_are_those_of_the_surface) {
    Scene scene = moving_scene(false);
    scene.camera.lens_aspect = 1.3f;
    const RenderOptions o = options();
    const Samples s = render_scene(scene, o, 1, {"basic", "z_gradient", "uv", "t", "motion"});
    PlainContext ctx;
    const RayScene rays(scene, ctx);
    const Camera camera(scene.camera, o.width, o.height);
    Rays ray;
    ray.resize(1);
    const auto depth = [&](double x, double y, size_t i, std::uint32_t& what) {
        const Camera::Ray r =
            camera.ray(float(x), float(y), s.uv()[2 * i], s.uv()[2 * i + 1], s.t()[i]);
        ray.set(0, r.origin, r.direction, 0, 1e30f, s.t()[i], every_mask);
        rays.intersect(ray, 0, 1);
        what = ray.object[0] == no_object ? no_object : ray.object[0] * 100000 + ray.primitive[0];
        return what == no_object
                   ? 0.0
                   : double(camera.to_camera(r.origin + r.direction * ray.distance[0], s.t()[i]).z);
    };
    size_t checked = 0;
    for (size_t i = 0; i < s.size(); i += 7) {
        std::uint32_t a, b, c;
        const double x = double(s.xy()[2 * i]), y = double(s.xy()[2 * i + 1]), step = 0.05;
        const double z = depth(x, y, i, a), zx = depth(x + step, y, i, b),
                     zy = depth(x, y + step, i, c);
        if (a == no_object || a != b || a != c) continue;
        const float* g = &s.values("z_gradient")[2 * i];
        EXPECT_NEAR((zx - z) / step, double(g[0]), 0.01 + 0.05 * std::fabs(double(g[0])));
        EXPECT_NEAR((zy - z) / step, double(g[1]), 0.01 + 0.05 * std::fabs(double(g[1])));
        ++checked;
    }
    EXPECT_GT(checked, 800u);
}

// A small bright ball out of focus is a disc of radius |C0 / z + C1|.
TEST(Trajectories, a_point_out_of_focus_becomes_a_disc_of_the_formulas_size) {
    Scene scene;
    scene.materials = {diffuse(0)};
    scene.materials[0].emission = {1, 1, 1};
    scene.meshes = {ball_mesh(8, false)};
    scene.instances = {placed(0, {scale(0.02f)})};
    scene.camera = camera_at({0, 0, 4}, {0, 0, 0}, 30);
    scene.camera.lens_radius = 0.1f;
    scene.camera.focus = 3;
    RenderOptions o;
    o.width = o.height = 64;
    const Samples s = render_scene(scene, o, 1024, {"basic"});
    double farthest = 0, squares = 0;
    size_t hits = 0;
    for (size_t i = 0; i < s.size(); ++i) {
        if (std::isinf(s.z()[i])) continue;
        const double r = std::hypot(double(s.xy()[2 * i]) - 32, double(s.xy()[2 * i + 1]) - 32);
        farthest = std::max(farthest, r), squares += r * r, ++hits;
    }
    const double scale_px = 32 / std::tan(double(radians(15)));
    const double radius = scale_px * 0.1 * (1.0 / 3 - 1.0 / 4);
    ASSERT_NEAR(std::fabs(double(s.lens->c0) / 4 + double(s.lens->c1)), radius, 1e-4);
    ASSERT_GT(hits, 500u);
    const double ball = 0.02 * scale_px / 4;
    EXPECT_NEAR(farthest, radius + ball, 0.1);
    // Of an even disc, and of the ball's own.
    EXPECT_NEAR(std::sqrt(squares / double(hits)), std::sqrt((radius * radius + ball * ball) / 2),
                0.05);
}

// A small ball that crosses the picture leaves a streak as long as it goes.
TEST(Trajectories, a_moving_point_leaves_a_streak_as_long_as_it_goes) {
    Scene scene;
    scene.materials = {diffuse(0)};
    scene.materials[0].emission = {1, 1, 1};
    scene.meshes = {ball_mesh(8, false)};
    scene.instances = {placed(
        0, {translate({-0.5f, 0, 0}) * scale(0.04f), translate({0.3f, 0, 0}) * scale(0.04f)})};
    scene.camera = camera_at({0, 0, 4}, {0, 0, 0}, 30);
    RenderOptions o;
    o.width = o.height = 64;
    for (const bool curved : {false, true}) {
        scene.camera.shutter_curve = curved ? std::vector<float>{0, 1, 0} : std::vector<float>{};
        const Samples s = render_scene(scene, o, 256, {"basic"});
        double low = 64, high = 0, mean = 0, squares = 0;
        size_t hits = 0;
        for (size_t i = 0; i < s.size(); ++i) {
            if (std::isinf(s.z()[i])) continue;
            const double x = double(s.xy()[2 * i]);
            low = std::min(low, x), high = std::max(high, x), mean += x, squares += x * x, ++hits;
        }
        mean /= double(hits);
        const double scale_px = 32 / std::tan(double(radians(15)));
        const double streak = 0.8 * scale_px / 4, size = 0.08 * scale_px / 4;
        const double deviation = std::sqrt(squares / double(hits) - mean * mean);
        EXPECT_NEAR(mean, 32 - 0.1 * scale_px / 4, 0.3);
        // Evenly in time, or as a triangle.
        EXPECT_NEAR(deviation, streak / std::sqrt(curved ? 24.0 : 12.0), 0.3);
        if (!curved) {
            EXPECT_GT(high - low, streak);  // its very tips are seen at the very ends only
            EXPECT_LT(high - low, streak + size + 0.01);
        }
    }
}

}  // namespace
}  // namespace weft::render
