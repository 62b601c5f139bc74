// clamp-indirect: a bound on what one path brings of light that was scattered before it bounced
// again. Paths are the same with and without it, so that samples can be compared one by one.
#include <algorithm>

#include "render/procedural_scene.h"
#include "render/render_test.h"

namespace weft::render {
namespace {

Samples cornell(float most) {
    RenderOptions o;
    o.width = o.height = 24;
    o.clamp_indirect = most;
    return render_scene(cornell_scene(1, 0.1f), o, 64, {"basic", "direct", "diffuse", "specular"});
}

float brightest(const float* rgb) {
    return largest({rgb[0], rgb[1], rgb[2]});
}

TEST(ClampIndirect, leaves_what_is_below_it_and_all_direct_light) {
    const Samples open = cornell(0), bound = cornell(1), far = cornell(1e9f);
    const auto all = open.rgb(), less = bound.rgb();
    ASSERT_TRUE(std::ranges::equal(all, far.rgb()));
    ASSERT_TRUE(std::ranges::equal(open.values("direct"), bound.values("direct")));
    size_t changed = 0;
    for (size_t i = 0; i < open.size(); ++i) {
        const float* before = &all[3 * i];
        const float* after = &less[3 * i];
        const float* direct = &open.values("direct")[3 * i];
        const float indirect[3] = {before[0] - direct[0], before[1] - direct[1],
                                   before[2] - direct[2]};
        // A path brings all of this at one hit, or some here and some there.
        if (brightest(indirect) <= 0.999f) {
            for (size_t c = 0; c < 3; ++c) ASSERT_EQ(before[c], after[c]);
        }
        for (size_t c = 0; c < 3; ++c) {
            ASSERT_LE(after[c], before[c] * 1.00001f);
            // Channels still add up: what the camera sees of the lamp itself is in neither.
            ASSERT_GE(after[c] * 1.0001f + 1e-5f,
                      bound.values("diffuse")[3 * i + c] + bound.values("specular")[3 * i + c]);
        }
        changed += !std::equal(before, before + 3, after);
    }
    EXPECT_GT(changed, open.size() / 1000);
    EXPECT_LT(changed, open.size() / 10);
}

TEST(ClampIndirect, takes_most_of_the_noise_and_little_of_the_light) {
    const Samples open = cornell(0), bound = cornell(1);
    const auto noise = [](const Samples& s) {
        const auto rgb = s.rgb(), direct = s.values("direct");
        std::vector<float> indirect;
        for (size_t i = 0; i < rgb.size(); i += 3) indirect.push_back(rgb[i] - direct[i]);
        return estimate(indirect);
    };
    const Estimate all = noise(open), less = noise(bound);
    EXPECT_LT(less.error, 0.5 * all.error);
    EXPECT_LT(less.mean, all.mean);
    EXPECT_GT(less.mean, 0.6 * all.mean);
}

// A lamp seen in glass or a mirror is no firefly.
TEST(ClampIndirect, leaves_what_is_mirrored_or_refracted_towards_the_camera) {
    Scene scene;
    Material glass;
    glass.kind = Material::Kind::dielectric;
    glass.base_color = {1, 1, 1}, glass.roughness = 0;
    Material mirror;
    mirror.kind = Material::Kind::conductor;
    mirror.base_color = {1, 1, 1}, mirror.roughness = 0;
    scene.materials = {glass, mirror};
    scene.meshes = {ball_mesh(32, true), floor_mesh(20, 1)};
    scene.instances = {placed(0, {translate({0, 1, 0})}), placed(1)};
    Light light;
    light.shape = Light::Shape::sphere;
    light.radiance = {50, 50, 50};
    light.to_world = {translate({0, 4, 0})};
    scene.lights = {light};
    scene.camera = camera_at({0, 2, 6}, {0, 1, 0}, 40);
    RenderOptions o;
    o.width = o.height = 16;
    const Samples open = render_scene(scene, o, 64, {"basic"});
    o.clamp_indirect = 1;
    const Samples bound = render_scene(scene, o, 64, {"basic"});
    EXPECT_GT(*std::max_element(open.rgb().begin(), open.rgb().end()), 10);
    EXPECT_TRUE(std::ranges::equal(open.rgb(), bound.rgb()));
}

}  // namespace
}  // namespace weft::render
