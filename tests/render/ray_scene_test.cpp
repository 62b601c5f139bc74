// Objects in Embree stand where we say they stand, at any time; lights are seen from one side.
#include "render/ray_scene.h"

#include "render/keyed_motion.h"
#include "render/render_test.h"
#include "render/surface.h"
#include "run_node.h"
#include "samples/random.h"

namespace weft::render {
namespace {

float difference(const Affine& a, const Affine& b) {
    float most = 0;
    for (const Vec3 d : {a.x - b.x, a.y - b.y, a.z - b.z, a.origin - b.origin})
        most = std::max(most, length(d));
    return most;
}

Affine some_transform(std::uint64_t i) {
    const auto r = [&](int k) { return 2 * unit_float(mix(16 * i + std::uint64_t(k))) - 1; };
    return translate({3 * r(0), 3 * r(1), 3 * r(2)}) * rotate({r(3), r(4), r(5)}, 1.5f * r(6)) *
           Affine{{1 + 0.5f * r(7), 0, 0},
                  {0.3f * r(8), 1 + 0.5f * r(9), 0},
                  {0, 0.3f * r(10), (r(11) > 0 ? 1.0f : -1.0f) * (1.2f + r(12))},
                  {}};
}

TEST(KeyedMotion, is_put_together_again_from_its_parts) {
    for (std::uint64_t i = 0; i < 500; ++i) {
        const Affine m = some_transform(i);
        ASSERT_LT(difference(compose(decompose(m)), m), 2e-5f) << i;
        ASSERT_LT(difference(m * inverse(m), Affine{}), 2e-4f) << i;
    }
}

TEST(KeyedMotion, a_turning_thing_keeps_its_size) {
    const KeyedMotion p({Affine{}, rotate({0, 1, 0}, 2.0f)});
    EXPECT_LT(difference(p.at(0.5f), rotate({0, 1, 0}, 1.0f)), 1e-5f);
}

// Several keys, turned, scaled and skewed; none passes through flatness.
std::vector<Affine> some_keys(std::uint64_t i) {
    std::vector<Affine> keys;
    for (std::uint64_t k = 0; k < 2 + i % 4; ++k) keys.push_back(some_transform(i * 8 + k));
    // Mirrored among others it would.
    for (Affine& key : keys)
        if (determinant(key) < 0) key.z = -key.z;
    return keys;
}

TEST(Placement, straight_steps_stay_near_the_motion_and_meet_its_keys) {
    float worst = 0;
    for (std::uint64_t i = 0; i < 200; ++i) {
        const std::vector<Affine> keys = some_keys(i);
        const KeyedMotion motion(keys);
        const Placement straight(keys);
        float size = 0;
        for (const Affine& key : keys)
            size = std::max({size, length(key.x), length(key.y), length(key.z)});
        for (int k = 0; k <= 1000; ++k) {
            const float t = float(k) / 1000;
            const float off = difference(straight.at(t), motion.at(t)) / size;
            ASSERT_LT(off, Placement::straight_enough + 2e-5f) << i << " at " << t;
            worst = std::max(worst, off);
        }
        for (size_t k = 0; k < keys.size(); ++k)
            ASSERT_EQ(straight.matrices()[k * (straight.matrices().size() - 1) / (keys.size() - 1)],
                      keys[k]);
    }
    EXPECT_GT(worst, Placement::straight_enough / 2);  // no more steps than it takes
}

TEST(Placement, what_does_not_turn_needs_no_further_steps) {
    const Affine start = rotate({1, 2, 3}, 0.7f) * scale(2.0f);
    EXPECT_EQ(Placement({start, translate({1, 2, 3}) * start}).matrices().size(), 2u);
    EXPECT_EQ(Placement({start, start}).matrices().size(), 1u);
}

TEST(Placement, a_ball_of_light_stays_round_as_it_turns) {
    Light light;
    light.shape = Light::Shape::sphere;
    light.to_world = {scale(2.0f), translate({1, 0, 0}) * rotate({0, 1, 0}, 2.0f) * scale(3.0f)};
    const Placement p = placement_of(light);
    for (const float t : {0.0f, 0.3f, 0.5f, 1.0f})
        EXPECT_LT(difference(p.at(t), translate({t, 0, 0}) * scale(2 + t)), 1e-5f) << t;
}

TEST(RayScene, objects_move_as_in_embree) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {ball_mesh(4, false)};
    for (std::uint64_t i = 0; i < 40; ++i) {
        std::vector<Affine> keys = some_keys(i);
        if (i % 5 == 0) keys = {some_transform(i), translate({1, 2, 3}) * some_transform(i)};
        scene.instances.push_back(placed(0, keys));
    }
    PlainContext ctx;
    const RayScene rays(scene, ctx);
    for (size_t i = 0; i < rays.objects().size(); ++i)
        for (const float t : {0.0f, 0.1f, 0.37f, 0.5f, 0.81f, 1.0f})
            EXPECT_LT(difference(rays.objects()[i].placement.at(t), rays.embree_transform(i, t)),
                      3e-5f)
                << i << " at " << t;
}

TEST(RayScene, a_hit_is_where_the_ray_went) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {ball_mesh(12, true), ball_mesh(12, true)};
    scene.meshes[1].steps = 3;
    const auto start = scene.meshes[1].positions;
    for (int k = 1; k < 3; ++k)
        for (const Vec3 p : start) {
            scene.meshes[1].positions.push_back(p * (1 + 0.2f * float(k * k)));
            scene.meshes[1].normals.push_back(unit(p));
        }
    scene.instances = {placed(0, {translate({-2, 0, 0})}),
                       placed(0, moving(translate({0, 2, 0}), {0.5f, 0, 0}, {0, 0, 1}, 3)),
                       placed(1, {translate({2, 0, 0})}),
                       placed(1, {translate({0, -2, 0}), translate({0, -2.5f, 1})})};
    PlainContext ctx;
    const RayScene rays(scene, ctx);
    constexpr size_t n = 4096;
    Rays r;
    r.resize(n);
    for (size_t i = 0; i < n; ++i) {
        const float a = 6.28f * unit_float(mix(5 * i)), b = 2 * unit_float(mix(5 * i + 1)) - 1;
        const Vec3 to{4 * unit_float(mix(5 * i + 2)) - 2, 4 * unit_float(mix(5 * i + 3)) - 2, 0};
        const Vec3 from{8 * std::cos(a), 8 * b, 8 * std::sin(a)};
        r.set(i, from, unit(to - from), 0, 1e30f, unit_float(mix(5 * i + 4)), every_mask);
    }
    rays.intersect(r, 0, n);
    size_t hits = 0, packet_differs = 0;
    std::vector<std::uint32_t> object = r.object;
    for (size_t i = 0; i < n; ++i) {
        if (r.object[i] == no_object) continue;
        ++hits;
        const SurfacePoint p =
            surface_at(rays.objects()[r.object[i]], r.primitive[i], r.u[i], r.v[i], r.time[i]);
        EXPECT_LT(length(p.position - (r.origin(i) + r.direction(i) * r.distance[i])), 1e-4f);
        EXPECT_LT(dot(p.geometric, r.direction(i)),
                  1e-3f);  // closed and wound outwards: seen from its front
    }
    EXPECT_GT(hits, 500u);
    rays.intersect_packet(r, 0, n);
    for (size_t i = 0; i < n; ++i) packet_differs += r.object[i] != object[i];
    EXPECT_LE(packet_differs, 2u);
    rays.occluded(r, 0, n);
    for (size_t i = 0; i < n; ++i) ASSERT_EQ(r.object[i] == no_object, object[i] == no_object);
}

// Twenty turns are more steps than Embree lets one geometry have. A ray down the middle of an arm
// that turns hits its flat top wherever it is and whenever, the very ends of its pieces included.
TEST(RayScene, a_rotor_is_there_at_all_times) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {floor_mesh(1), floor_mesh(1)};
    scene.instances = {placed(1, {translate({0, -5, 0})}, 7),
                       placed(0,
                              moving(translate({0, 1, 0}) * scale(Vec3{1, 1, 0.01f}), {0, 2, 0},
                                     {0, 1, 0}, 20 * 2 * pi),
                              8),
                       placed(1, {translate({0, -6, 0}), translate({0, -7, 0})}, 9)};
    PlainContext ctx;
    const RayScene rays(scene, ctx);
    const Object& rotor = rays.objects()[1];
    ASSERT_GT(rotor.placement.pieces(), 8u);
    std::vector<float> times;
    for (size_t i = 0; i <= rotor.placement.pieces(); ++i) {
        const float at = float(i) / float(rotor.placement.pieces());
        for (const float t : {std::nextafter(at, 0.0f), at, std::nextafter(at, 1.0f)})
            times.push_back(t);
    }
    for (std::uint64_t i = 0; i < 2000; ++i) times.push_back(unit_float(mix(i)));
    Rays r;
    r.resize(times.size());
    const auto aim = [&] {
        for (size_t i = 0; i < times.size(); ++i) {
            const Vec3 tip = rotor.placement.at(times[i]).point({0.9f, 0, 0});
            ASSERT_NEAR(std::hypot(tip.x, tip.z), 0.9f, 0.9f * Placement::straight_enough + 1e-5f);
            r.set(i, {tip.x, 9, tip.z}, {0, -1, 0}, 0, 1e30f, times[i], every_mask);
        }
    };
    const auto check = [&](const char* how) {
        for (size_t i = 0; i < times.size(); ++i) {
            ASSERT_EQ(r.object[i], 1u) << how << " at " << times[i];
            ASSERT_NEAR(r.distance[i], 8 - 2 * times[i], 1e-4f);
            const SurfacePoint p = surface_at(rotor, r.primitive[i], r.u[i], r.v[i], times[i]);
            ASSERT_LT(length(p.position - (r.origin(i) + r.direction(i) * r.distance[i])), 3e-5f);
        }
    };
    aim();
    rays.intersect(r, 0, times.size());
    check("one by one");
    aim();
    rays.intersect_packet(r, 0, times.size());
    check("in packets");
    aim();
    rays.occluded(r, 0, times.size());
    for (size_t i = 0; i < times.size(); ++i) ASSERT_EQ(r.object[i], 0u) << times[i];
    for (const float t : times)
        ASSERT_LT(difference(rotor.placement.at(t), rays.embree_transform(1, t)), 3e-5f) << t;
    r.set(0, {0, -5.5f, 0}, {0, -1, 0}, 0, 1e30f, 0.5f, every_mask);
    rays.intersect(r, 0, 1);
    EXPECT_EQ(r.object[0], 2u);
}

TEST(RayScene, lights_are_seen_from_where_they_shine) {
    for (const auto shape : {Light::Shape::quad, Light::Shape::disc, Light::Shape::sphere}) {
        Scene scene;
        Light light;
        light.shape = shape;
        light.to_world = {scale(2.0f)};
        scene.lights = {light};
        PlainContext ctx;
        const RayScene rays(scene, ctx);
        Rays r;
        r.resize(4);
        // Along -z the light shines, so it is seen by rays that run along +z.
        r.set(0, {0, 0, -9}, {0, 0, 1}, 0, 1e30f, 0.3f, every_mask);
        r.set(1, {0, 0, 9}, {0, 0, -1}, 0, 1e30f, 0.3f, every_mask);
        r.set(2, {1.9f, 1.9f, -9}, {0, 0, 1}, 0, 1e30f, 0.3f,
              every_mask);                                              // in a corner of the square
        r.set(3, {0, 0, 0.5f}, {0, 0, 1}, 0, 1e30f, 0.3f, every_mask);  // from inside the sphere
        rays.intersect(r, 0, 4);
        const bool sphere = shape == Light::Shape::sphere;
        EXPECT_EQ(r.object[0], 0u);
        EXPECT_NEAR(r.distance[0], sphere ? 7 : 9, 1e-4f);
        EXPECT_EQ(r.object[1], sphere ? 0u : no_object);
        EXPECT_EQ(r.object[2], shape == Light::Shape::quad ? 0u : no_object);
        EXPECT_EQ(r.object[3], no_object);
    }
}

TEST(RayScene, what_cannot_be_traced_is_said) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {floor_mesh(1)};
    scene.instances = {placed(0, {Affine{{1, 0, 0}, {0, 0, 0}, {0, 0, 1}, {}}})};
    scene.instances[0].name = "shadow";
    PlainContext ctx;
    ASSERT_EQ(RayScene(scene, ctx).left_out().size(), 1u);
    EXPECT_NE(RayScene(scene, ctx).left_out()[0].find("'shadow' is squashed flat"),
              std::string::npos);
    scene.meshes[0].positions[1].x = NAN;
    EXPECT_THROW(RayScene(scene, ctx), Error);
    scene.instances[0].to_world.resize(200);
    scene.meshes = {floor_mesh(1)};
    EXPECT_EQ(error_of([&] { RayScene(scene, ctx); }),
              "instance 0 ('shadow'): has 200 motion keys; at most 129 work");
}

}  // namespace
}  // namespace weft::render
