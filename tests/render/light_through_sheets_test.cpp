// Light that goes straight through: thin glass, partial opacity, bodies that bend nothing. It is
// found by shadow rays and by the paths' own, and must be counted once; what bends light is passed
// by paths alone.
#include "render/render_test.h"

namespace weft::render {
namespace {

constexpr float lamp_height = 1.5f, lamp_half = 0.7f;

// Clear thin glass as glTF has it: one interface, not bent.
Material pane_of(Vec3 color, float transmission = 1) {
    Material m;
    m.base_color = color;
    m.roughness = 0;
    m.transmission = transmission;
    return m;
}
double pane_passes(double color, double cosine) {
    return color * (1 - 0.04) * (1 - std::pow(1 - cosine, 5));
}

// A grey floor under a square lamp, with sheets of `sheet` between them, seen from below them.
Scene lamp_behind(const Material& sheet, int sheets, bool visible) {
    Scene scene;
    scene.materials = {diffuse(0.5f), sheet};
    scene.meshes = {floor_mesh(50), floor_mesh(40, 1)};
    scene.instances = {placed(0)};
    for (int i = 0; i < sheets; ++i)
        scene.instances.push_back(placed(1, {translate({0, 0.7f + 0.1f * float(i), 0})}));
    Light light;
    light.radiance = {3, 2, 1};
    light.visible = visible;
    light.to_world = {translate({0, lamp_height, 0}) * rotate({1, 0, 0}, -pi / 2) *
                      scale(lamp_half)};
    scene.lights = {light};
    scene.camera = camera_at({1, 0.5f, 0}, {1, 0, 0}, 5, {0, 0, -1});
    return scene;
}

// The same lamp as an emitting mesh.
Scene mesh_lamp_behind(const Material& sheet, int sheets) {
    Scene scene = lamp_behind(sheet, sheets, true);
    scene.lights.clear();
    Material shine = diffuse(0);
    shine.emission = {3, 2, 1};
    shine.two_sided = false;
    scene.materials.push_back(shine);
    scene.meshes.push_back(floor_mesh(lamp_half, 2));
    scene.instances.push_back(placed(2, {translate({0, lamp_height, 0}) * rotate({1, 0, 0}, pi)}));
    return scene;
}

// Radiance that leaves the floor at (x, 0, z) for a lamp of radiance 1, by quadrature over the
// lamp; `passes(cosine)` is what goes through all that is between.
template <class Passes>
double floor_radiance(double x, double z, Passes&& passes) {
    constexpr int n = 64;
    double sum = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double dx = lamp_half * (2 * (i + 0.5) / n - 1) - x,
                         dz = lamp_half * (2 * (j + 0.5) / n - 1) - z,
                         d2 = dx * dx + dz * dz + lamp_height * lamp_height,
                         cosine = lamp_height / std::sqrt(d2);
            sum += cosine * cosine / d2 * passes(cosine);
        }
    return 0.5 / double(pi) * sum * 4 * lamp_half * lamp_half / (n * n);
}

template <class Passes>
double expected_mean(const Samples& s, Passes&& passes) {
    const auto position = s.values("position");
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < s.size(); i += 257, ++count)
        sum += floor_radiance(double(position[3 * i]), double(position[3 * i + 2]), passes);
    return sum / double(count);
}

RenderOptions direct() {
    RenderOptions o;
    o.width = o.height = 8;
    o.max_depth = 1;
    return o;
}

TEST(LightThroughSheets, of_clear_glass_is_what_fresnel_lets_pass) {
    for (const int panes : {1, 2}) {
        const auto passes = [&](double c) { return std::pow(pane_passes(0.9, c), panes); };
        const Material pane = pane_of({0.9f, 0.9f, 0.9f});
        for (const Scene& scene : {lamp_behind(pane, panes, false), lamp_behind(pane, panes, true),
                                   mesh_lamp_behind(pane, panes)}) {
            const Samples s = render_scene(scene, direct(), 1024, {"position"});
            const double expected = 3 * expected_mean(s, passes);
            const Estimate got = estimate(s.rgb(), 3);
            EXPECT_NEAR(got.mean, expected, 0.003 * expected) << panes;
        }
    }
}

// By a light too dim to be chosen beside another far away: paths alone find it.
TEST(LightThroughSheets, is_found_by_paths_as_by_shadow_rays) {
    for (const int panes : {1, 2}) {
        Scene scene = lamp_behind(pane_of({0.9f, 0.9f, 0.9f}), panes, true);
        scene.lights.push_back(scene.lights[0]);
        scene.lights[1].shape = Light::Shape::point;
        scene.lights[1].radiance = {0, 1e9f, 0};
        scene.lights[1].to_world = {translate({0, -1000, 0})};
        RenderOptions o = direct();
        o.sampler = Sampler::independent;
        const Samples s = render_scene(scene, o, 8192, {"position"});
        const double expected =
            3 * expected_mean(s, [&](double c) { return std::pow(pane_passes(0.9, c), panes); });
        const Estimate got = estimate(s.rgb(), 3);
        EXPECT_NEAR(got.mean, expected, 4 * got.error) << panes;
        EXPECT_LT(got.error, 0.02 * expected);
    }
}

TEST(LightThroughSheets, keeps_their_colour_and_loses_what_they_scatter) {
    const Samples s = render_scene(lamp_behind(pane_of({0.8f, 0.4f, 0.1f}, 0.5f), 1, false),
                                   direct(), 1024, {"position"});
    const double color[3] = {0.8, 0.4, 0.1}, radiance[3] = {3, 2, 1};
    for (size_t c = 0; c < 3; ++c) {
        std::vector<float> channel;
        for (size_t i = 0; i < s.size(); ++i) channel.push_back(s.rgb()[3 * i + c]);
        const double expected = radiance[c] * expected_mean(s, [&](double cosine) {
                                    return pane_passes(color[c], cosine) * 0.5;
                                });
        EXPECT_NEAR(estimate(channel).mean, expected, 0.003 * expected) << c;
    }
}

TEST(LightThroughSheets, of_partial_opacity_is_dimmed_without_noise) {
    Material veil = diffuse(0);
    veil.alpha = Material::Alpha::blend;
    veil.opacity = 0.4f;
    for (const int veils : {1, 3}) {
        Scene scene = lamp_behind(veil, veils, true);
        scene.lights[0].shape = Light::Shape::point;
        const Samples s = render_scene(scene, direct(), 16, {"position"});
        const auto position = s.values("position");
        for (size_t i = 0; i < s.size(); ++i) {
            const double x = double(position[3 * i]), z = double(position[3 * i + 2]),
                         d2 = x * x + z * z + double(lamp_height * lamp_height);
            const double clear = 3 * 0.5 / double(pi) * double(lamp_height) / std::pow(d2, 1.5);
            ASSERT_NEAR(double(s.rgb()[3 * i]), clear * std::pow(0.6, veils), 1e-4 * clear);
        }
    }
    const Samples s = render_scene(lamp_behind(veil, 1, true), direct(), 1024, {"position"});
    const double expected = 3 * expected_mean(s, [](double) { return 0.6; });
    EXPECT_NEAR(estimate(s.rgb(), 3).mean, expected, 0.003 * expected);
}

// A sheet of glass with holes: what is there lets pass what glass does.
TEST(LightThroughSheets, of_partly_opaque_glass_is_of_both) {
    Material pane = pane_of({0.9f, 0.9f, 0.9f});
    pane.alpha = Material::Alpha::blend;
    pane.opacity = 0.5f;
    const Samples s = render_scene(lamp_behind(pane, 1, true), direct(), 4096, {"position"});
    const double expected =
        3 * expected_mean(s, [](double c) { return 0.5 + 0.5 * pane_passes(0.9, c); });
    const Estimate got = estimate(s.rgb(), 3);
    EXPECT_NEAR(got.mean, expected, 0.003 * expected + 4 * got.error);
}

TEST(LightThroughSheets, of_a_body_that_bends_nothing_is_all_of_it) {
    for (const float roughness : {0.0f, 0.5f}) {
        Material air;
        air.kind = Material::Kind::dielectric;
        air.ior = 1, air.base_color = {1, 1, 1}, air.roughness = roughness;
        Scene scene = lamp_behind(air, 0, true);
        scene.meshes.push_back(ball_mesh(16, false, 1));
        scene.instances.push_back(placed(2, {translate({0.3f, 0.7f, 0}) * scale(0.5f)}));
        const Samples s = render_scene(scene, direct(), 1024, {"position"});
        const double expected = 3 * expected_mean(s, [](double) { return 1.0; });
        EXPECT_NEAR(estimate(s.rgb(), 3).mean, expected, 0.003 * expected);
    }
}

// An even sky seen through a pane, off it, and through a pane on a floor: all is 1.
TEST(LightThroughSheets, glass_vanishes_in_a_furnace) {
    Scene scene;
    scene.materials = {pane_of({1, 1, 1}), diffuse(1)};
    scene.meshes = {floor_mesh(1), floor_mesh(200, 1)};
    scene.instances = {placed(0), placed(0, {translate({0, 0.3f, 0})})};
    scene.environment.radiance = {1, 1, 1};
    RenderOptions o = direct();
    o.max_depth = 30, o.roulette_depth = 20;
    for (const Vec3 eye : {Vec3{0, 4, 0.1f}, Vec3{0, 1, 2}}) {
        scene.camera = camera_at(eye, {0, 0, 0}, 10);
        const Estimate alone = estimate(render_scene(scene, o, 256, {"basic"}).rgb(), 3);
        EXPECT_NEAR(alone.mean, 1, 0.004 + 4 * alone.error);
    }
    // Between white walls light is caught for as many bounces as there are: a share of the floor's
    // light that the panes send back is back again.
    scene.instances = {placed(0, {translate({0, 0.3f, 0}) * scale(100)}), placed(1)};
    scene.camera = camera_at({0, 0.2f, 0.1f}, {0, 0, 0}, 10);
    o.max_depth = 200, o.roulette_depth = 100;
    const Estimate floor = estimate(render_scene(scene, o, 1024, {"basic"}).rgb(), 3);
    EXPECT_NEAR(floor.mean, 1, 0.01 + 4 * floor.error);
}

TEST(LightThroughSheets, is_seen_by_the_camera_whatever_the_depth) {
    Scene scene;
    scene.materials = {pane_of({1, 1, 1})};
    scene.meshes = {floor_mesh(1)};
    scene.instances = {placed(0), placed(0, {translate({0, 0.1f, 0})})};
    scene.environment.radiance = {2, 2, 2};
    scene.camera = camera_at({0, 1, 0}, {0, 0, 0}, 1, {0, 0, -1});
    RenderOptions o = direct();
    for (const int depth : {0, 1, 4}) {
        o.max_depth = depth;
        const Samples s = render_scene(
            scene, o, 1024,
            {"basic", "direct", "diffuse", "specular", "emission", "direct_unshadowed"});
        const Estimate got = estimate(s.rgb(), 3);
        // Reflections come from the third bounce on as from the first: of both panes' 4 %.
        const double passed = 2 * 0.96 * 0.96;
        EXPECT_GT(got.mean, passed - 4 * got.error) << depth;
        if (depth == 0) {
            EXPECT_NEAR(got.mean, passed, 0.002 * passed + 4 * got.error);
        }
        const auto rgb = s.rgb();
        for (size_t i = 0; i < rgb.size(); ++i)
            ASSERT_NEAR(rgb[i],
                        s.values("diffuse")[i] + s.values("specular")[i] + s.values("emission")[i],
                        1e-4f * (1 + rgb[i]));
    }
}

// Shadow rays of a batch go through their sheets together, and must not notice.
TEST(LightThroughSheets, does_not_depend_on_who_else_is_traced) {
    Material veil = diffuse(0.5f);
    veil.alpha = Material::Alpha::blend;
    veil.opacity = 0.4f;
    Scene scene = lamp_behind(veil, 2, true);
    scene.materials.push_back(pane_of({0.9f, 0.5f, 0.5f}, 0.5f));
    scene.instances.push_back(placed(1, {translate({0, 1, 0}) * rotate({1, 0, 0}, 0.3f)}));
    scene.instances.back().material = 2;
    RenderOptions o = direct();
    o.max_depth = 4;
    o.channels = channel_set(std::vector<std::string>{"rgb"}, false, false);
    PlainContext ctx;
    const PathTracer tracer(scene, o, ctx);
    const PathWorkspacePointer workspace = tracer.workspace();
    std::vector<PixelRun> runs;
    for (int x = 0; x < 8; ++x) runs.push_back({x, 3, 0, 16, 16});
    SampleBatch together, alone;
    tracer.render(runs, *workspace, together);
    for (size_t r = 0; r < runs.size(); ++r) {
        tracer.render({&runs[r], 1}, *workspace, alone);
        for (size_t i = 0; i < 16; ++i)
            for (size_t c = 0; c < 3; ++c)
                ASSERT_EQ(alone.at(ChannelId::rgb, i)[c],
                          together.at(ChannelId::rgb, 16 * r + i)[c]);
    }
}

// A small lamp in the middle of a glass ball: rays meet the glass along its normal, so 96 % pass.
// From outside the lamp is larger by the index and darker by its square: as bright as without
// glass.
TEST(LightThroughSheets, of_a_glass_ball_is_found_by_bent_paths_alone) {
    Scene scene;
    Material glass;
    glass.kind = Material::Kind::dielectric;
    glass.base_color = {1, 1, 1}, glass.roughness = 0;
    scene.materials = {diffuse(0.5f), glass};
    scene.meshes = {floor_mesh(50), ball_mesh(128, true, 1)};
    scene.instances = {placed(0), placed(1, {translate({0, 2, 0})})};
    Light light;
    light.shape = Light::Shape::sphere;
    light.radiance = {3, 3, 3};
    light.to_world = {translate({0, 2, 0}) * scale(0.3f)};
    scene.lights = {light};
    scene.camera = camera_at({0.2f, 0.9f, 0}, {0.2f, 0, 0}, 5, {0, 0, -1});
    RenderOptions o = direct();
    o.max_depth = 4;
    const Samples s = render_scene(scene, o, 16384, {"position"});
    const double distance2 = 4 + 0.04, cosine = 2 / std::sqrt(distance2);
    const double expected = 3 * 0.5 * 0.3 * 0.3 / distance2 * cosine * 0.96;
    const Estimate got = estimate(s.rgb(), 3);
    EXPECT_NEAR(got.mean, expected, 0.03 * expected + 4 * got.error);
    // What no path can hit, no shadow ray reaches.
    scene.lights[0].shape = Light::Shape::point;
    const Samples dark = render_scene(scene, o, 64, {"basic"});
    for (const float v : dark.rgb()) ASSERT_EQ(v, 0);
}

}  // namespace
}  // namespace weft::render
