// Light whose amount is known: a furnace, a quad over a plane, a sphere; and estimators that must
// agree with each other.
#include "render/render_test.h"

namespace weft::render {
namespace {

Scene quad_over_floor(float half, float height, Light::Shape shape = Light::Shape::quad) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {floor_mesh(50)};
    scene.instances = {placed(0)};
    Light light;
    light.name = "lamp";
    light.shape = shape;
    light.radiance = {3, 2, 1};
    light.visible = shape != Light::Shape::quad;
    // Its -z looks down: x stays, y becomes -z.
    light.to_world = {translate({0, height, 0}) * rotate({1, 0, 0}, -pi / 2) * scale(half)};
    scene.lights = {light};
    scene.camera = camera_at({1, 6, 0}, {1, 0, 0}, 0.5f, {0, 0, -1});
    return scene;
}

// Irradiance on a plane under a parallel rectangle: four corner form factors (Modest, configuration
// 38).
double quad_form_factor(double x, double z, double half, double h) {
    const auto corner = [&](double a, double b) {
        const double s = a < 0 ? -1 : 1, t = b < 0 ? -1 : 1;
        a = std::fabs(a) / h, b = std::fabs(b) / h;
        const double p = std::sqrt(1 + a * a), q = std::sqrt(1 + b * b);
        return s * t * (a / p * std::atan(b / p) + b / q * std::atan(a / q)) / (2 * double(pi));
    };
    return corner(half - x, half - z) + corner(half + x, half - z) + corner(half - x, half + z) +
           corner(half + x, half + z);
}

RenderOptions small() {
    RenderOptions o;
    o.width = 8, o.height = 8;
    return o;
}

TEST(KnownLight, a_quad_lights_a_plane_as_its_form_factor_says) {
    const Scene scene = quad_over_floor(0.7f, 1.5f);
    RenderOptions o = small();
    o.max_depth = 1;
    const Samples s = render_scene(scene, o, 1024, {"position"});
    double expected = 0;
    const auto position = s.values("position");
    for (size_t i = 0; i < s.size(); ++i)
        expected +=
            3 * 0.5 *
            quad_form_factor(double(position[3 * i]), double(position[3 * i + 2]), 0.7, 1.5);
    expected /= double(s.size());
    const Estimate got = estimate(s.rgb(), 3);
    EXPECT_NEAR(got.mean, expected, 0.001 * expected);
}

TEST(KnownLight, a_sphere_lights_a_plane_as_its_form_factor_says) {
    const float radius = 0.5f, height = 2;
    Scene scene = quad_over_floor(radius, height, Light::Shape::sphere);
    RenderOptions o = small();
    o.max_depth = 1;
    const Samples s = render_scene(scene, o, 1024, {"position"});
    double expected = 0;
    const auto position = s.values("position");
    for (size_t i = 0; i < s.size(); ++i) {
        const double x = double(position[3 * i]), z = double(position[3 * i + 2]),
                     d2 = x * x + z * z + double(height * height);
        expected += 3 * 0.5 * double(radius * radius) / d2 * double(height) / std::sqrt(d2);
    }
    EXPECT_NEAR(estimate(s.rgb(), 3).mean, expected / double(s.size()),
                0.002 * expected / double(s.size()));
}

TEST(KnownLight, a_point_a_spot_and_a_sun_light_a_plane_by_the_cosine_law) {
    for (const auto shape : {Light::Shape::point, Light::Shape::spot, Light::Shape::directional}) {
        Scene scene = quad_over_floor(1, 2, shape);
        scene.lights[0].inner_cone = 1.2f, scene.lights[0].outer_cone = 1.3f;
        const Samples s = render_scene(scene, small(), 16, {"position"});
        const auto position = s.values("position");
        for (size_t i = 0; i < s.size(); ++i) {
            const double x = double(position[3 * i]), z = double(position[3 * i + 2]),
                         d2 = x * x + z * z + 4;
            const double irradiance =
                shape == Light::Shape::directional ? 3 : 3 / d2 * 2 / std::sqrt(d2);
            ASSERT_NEAR(double(s.rgb()[3 * i]), 0.5 / double(pi) * irradiance, 1e-4);
        }
    }
}

// In an even sky of radiance 1 a convex white ball is as bright as the sky.
TEST(KnownLight, nothing_is_lost_in_a_furnace) {
    for (const float albedo : {1.0f, 0.5f})
        for (const bool smooth : {false, true}) {
            Scene scene;
            scene.materials = {diffuse(albedo)};
            scene.meshes = {ball_mesh(32, smooth)};
            scene.instances = {placed(0)};
            scene.environment.radiance = {1, 1, 1};
            scene.camera = camera_at({0, 0, 5}, {0, 0, 0}, 16);
            RenderOptions o = small();
            o.max_depth = 20;
            const Estimate got = estimate(render_scene(scene, o, 256, {"basic"}).rgb(), 3);
            // Interpolated normals send some light through the facets.
            EXPECT_NEAR(got.mean, double(albedo), (smooth ? 0.01 : 0.002) + 4 * got.error);
        }
}

TEST(KnownLight, glass_and_mirror_vanish_in_a_furnace) {
    for (const auto kind : {Material::Kind::dielectric, Material::Kind::conductor})
        for (const float roughness : {0.0f, 0.4f}) {
            Scene scene;
            Material m;
            m.kind = kind, m.base_color = {1, 1, 1}, m.roughness = roughness;
            scene.materials = {m};
            scene.meshes = {ball_mesh(64, false)};
            scene.instances = {placed(0)};
            scene.environment.radiance = {1, 1, 1};
            scene.camera = camera_at({0, 0, 5}, {0, 0, 0}, 16);
            RenderOptions o = small();
            o.max_depth = 200, o.roulette_depth = 100;
            const Estimate got = estimate(render_scene(scene, o, 256, {"basic"}).rgb(), 3);
            // Rough: light that meets a second microfacet is lost, a few per cent a surface.
            EXPECT_GT(got.mean, roughness > 0 ? 0.9 : 0.998);
            EXPECT_LT(got.mean, 1 + 4 * got.error + 1e-3);
        }
}

// Two light samplers and the BSDF's own: all must give the same picture.
TEST(KnownLight, estimators_agree) {
    Scene scene = quad_over_floor(0.7f, 1.5f, Light::Shape::disc);
    scene.materials.push_back({});
    scene.materials[0].kind = Material::Kind::conductor;
    scene.materials[0].roughness = 0.5f;
    RenderOptions o = small();
    o.max_depth = 1;
    o.sampler = Sampler::independent;
    // Both together, with weights.
    const Estimate both = estimate(render_scene(scene, o, 2048, {"basic"}).rgb(), 3);
    // Light sampling alone: what direct_unshadowed is about; nothing casts a shadow here.
    o.seed = 2;
    const Samples lights = render_scene(scene, o, 2048, {"direct_unshadowed"});
    const Estimate alone = estimate(lights.values("direct_unshadowed"), 3);
    // The BSDF alone: a light too dim to be chosen beside another far away.
    scene.lights.push_back(scene.lights[0]);
    scene.lights[1].shape = Light::Shape::point;
    scene.lights[1].radiance = {0, 1e9f, 0};
    scene.lights[1].to_world = {translate({0, -1000, 0})};
    o.seed = 3;
    const Estimate bsdf = estimate(render_scene(scene, o, 8192, {"basic"}).rgb(), 3);
    const auto z = [](Estimate a, Estimate b) {
        return std::fabs(a.mean - b.mean) / std::hypot(a.error, b.error);
    };
    EXPECT_GT(both.mean, 0.01);
    EXPECT_LT(z(both, alone), 4);
    EXPECT_LT(z(both, bsdf), 4);
    EXPECT_LT(both.error, bsdf.error);
}

TEST(KnownLight, an_environment_map_is_sampled_as_bright_as_it_is) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {floor_mesh(50)};
    scene.instances = {placed(0)};
    auto map = std::make_shared<Image>(64, 32, 3);
    // A small sun, 200 times brighter than its sky.
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x)
            for (int c = 0; c < 3; ++c)
                map->at(x, y)[c] = x >= 20 && x < 23 && y >= 5 && y < 8 ? 200.0f : 1.0f;
    scene.environment.map = map;
    scene.environment.radiance = {1, 1, 1};
    scene.environment.rotation = 0.8f;
    scene.camera = camera_at({1, 6, 0}, {1, 0, 0}, 0.5f, {0, 0, -1});
    // By quadrature over the upper half, through the same bilinear look-up.
    const EnvironmentLight sky(scene.environment);
    double expected = 0, density = 0;
    constexpr int rows = 1000, columns = 2000;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const double c = (i + 0.5) / rows * 2 - 1, phi = 2 * double(pi) * (j + 0.5) / columns,
                         r = std::sqrt(1 - c * c);
            const Vec3 d{float(r * std::cos(phi)), float(c), float(r * std::sin(phi))};
            const double solid = 2.0 / rows * 2 * double(pi) / columns;
            if (c > 0) expected += double(sky.radiance(d).x) * c * solid;
            density += double(sky.density(d)) * solid;
        }
    expected *= 0.5 / double(pi);
    EXPECT_NEAR(density, 1, 0.01);
    RenderOptions o = small();
    o.max_depth = 1;
    const Estimate got = estimate(render_scene(scene, o, 1024, {"basic"}).rgb(), 3);
    EXPECT_NEAR(got.mean, expected, 0.003 * expected + 4 * got.error);
    EXPECT_LT(got.error,
              0.01 * expected);  // importance sampling: without it the sun makes this 0.04
}

TEST(KnownLight, an_emitting_mesh_lights_like_a_quad_light) {
    Scene lamp = quad_over_floor(0.7f, 1.5f);
    RenderOptions o = small();
    o.max_depth = 1;
    const Estimate quad = estimate(render_scene(lamp, o, 1024, {"basic"}).rgb(), 3);
    Scene mesh = lamp;
    mesh.lights.clear();
    Material shine = diffuse(0);
    shine.emission = {3, 2, 1};
    shine.two_sided = false;
    mesh.materials.push_back(shine);
    mesh.meshes.push_back(floor_mesh(0.7f, 1));
    mesh.instances.push_back(placed(1, {translate({0, 1.5f, 0}) * rotate({1, 0, 0}, pi)}, 2));
    mesh.camera.to_world = {look_at({1, 1.4f, 0}, {1, 0, 0}, {0, 0, -1})};
    mesh.camera.vertical_fov = 2 * std::atan(std::tan(radians(0.25f)) * 6 / 1.4f);
    const Estimate got = estimate(render_scene(mesh, o, 1024, {"basic"}).rgb(), 3);
    EXPECT_NEAR(got.mean, quad.mean, 0.003 * quad.mean);
}

TEST(KnownLight, channels_add_up) {
    Scene scene = quad_over_floor(0.7f, 1.5f);
    scene.materials[0] = Material{};
    scene.materials[0].roughness = 0.4f;
    scene.environment.radiance = {0.2f, 0.2f, 0.2f};
    scene.meshes.push_back(ball_mesh(16, true));
    scene.instances.push_back(placed(1, {translate({1, 0.3f, 0}) * scale(0.2f)}, 7));
    scene.camera.vertical_fov = radians(8);
    RenderOptions o = small();
    const Samples s = render_scene(scene, o, 64,
                                   {"basic", "direct", "diffuse", "specular", "emission", "id",
                                    "light_uv", "light_index", "bounce", "normal"});
    const auto rgb = s.rgb(), direct = s.values("direct"), diffuse = s.values("diffuse"),
               specular = s.values("specular"), emission = s.values("emission");
    size_t balls = 0, still = 0;
    for (size_t i = 0; i < rgb.size(); ++i) {
        ASSERT_NEAR(rgb[i], diffuse[i] + specular[i] + emission[i], 1e-4f * (1 + rgb[i]));
        ASSERT_LE(direct[i], rgb[i] * 1.0001f + 1e-6f);
    }
    for (size_t i = 0; i < s.size(); ++i) {
        balls += s.find("id")->ids[i] == 7;
        ASSERT_LT(s.find("light_index")->ids[i], 2u);
        const float* d = &s.values("bounce")[3 * i];
        const float l = length({d[0], d[1], d[2]});  // 0 where the lobe points into the surface
        still += l == 0;
        ASSERT_TRUE(l == 0 || std::fabs(l - 1) < 1e-4f) << l;
    }
    EXPECT_LT(still, s.size() / 20);
    EXPECT_GT(balls, s.size() / 50);
    EXPECT_LT(balls, s.size());
}

TEST(KnownLight, many_pictures_of_one_sample_make_the_converged_one) {
    Scene scene = quad_over_floor(0.7f, 1.5f, Light::Shape::disc);
    scene.meshes.push_back(ball_mesh(16, true));
    scene.instances.push_back(placed(1, {translate({1, 0.3f, 0}) * scale(0.2f)}, 7));
    scene.camera.vertical_fov = radians(8);
    scene.camera.lens_radius = 0.05f;
    RenderOptions o = small();
    for (const Sampler sampler : {Sampler::independent, Sampler::stratified, Sampler::sobol}) {
        o.sampler = sampler;
        o.seed = 1;
        const Estimate whole = estimate(render_scene(scene, o, 4096, {"basic"}).rgb(), 3);
        std::vector<float> means;
        for (std::uint64_t seed = 100; seed < 400; ++seed) {
            o.seed = seed;
            means.push_back(float(estimate(render_scene(scene, o, 1, {"basic"}).rgb(), 3).mean));
        }
        const Estimate many = estimate(means);
        EXPECT_LT(std::fabs(many.mean - whole.mean), 4 * std::hypot(many.error, whole.error))
            << int(sampler);
    }
}

}  // namespace
}  // namespace weft::render
