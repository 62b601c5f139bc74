// pixel-features: means and variances against exact values, and what becomes of bad samples.
#include <gtest/gtest.h>

#include <limits>

#include "filters/pictures.h"
#include "tests/run_node.h"
#include "tests/sample_buffer.h"

namespace weft {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

struct Made {
    Image color, color_variance, features, features_variance, count;
    std::vector<std::string> warnings;
};
Made features_of(const Samples& samples, std::vector<std::string> channels = {}) {
    RunNode node("pixel-features");
    node.in("samples", samples);
    Json list = Json::list({});
    for (const std::string& name : channels) list.items.push_back(Json(name));
    node.set("channels", list);
    Made made;
    const TypeInfo* type = &type_info<Image>();
    node.run({{"color", type, &made.color, {}},
              {"color-variance", type, &made.color_variance, {}},
              {"features", type, &made.features, {}},
              {"features-variance", type, &made.features_variance, {}},
              {"count", type, &made.count, {}}});
    made.warnings = node.ctx.warnings;
    return made;
}

// Samples whose rgb and normal are given, counts[pixel] a pixel.
Samples make_samples(int width, int height, const std::vector<size_t>& counts,
                     std::vector<float> rgb, std::vector<float> normal = {}) {
    Samples s = placed_samples(
        width, height, [&](size_t p) { return counts[p]; }, middle);
    s.add("rgb", 3, std::move(rgb));
    if (!normal.empty()) s.add("normal", 3, std::move(normal));
    return s;
}

TEST(PixelFeatures, mean_and_variance_of_the_mean_are_exact) {
    const Made made = features_of(make_samples(2, 1, {2, 4},
                                               {1, 0, 5, 3, 0, 7,  //
                                                2, 1, 0, 4, 1, 0, 6, 1, 0, 8, 1, 0}));
    EXPECT_EQ(made.color.names(), (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_EQ(made.color.at(0, 0)[0], 2);
    EXPECT_EQ(made.color.at(0, 0)[2], 6);
    EXPECT_EQ(made.color.at(1, 0)[0], 5);
    EXPECT_EQ(made.color_variance.at(0, 0)[0], 1);  // of samples: 2; of their mean: half
    EXPECT_EQ(made.color_variance.at(0, 0)[1], 0);
    EXPECT_NEAR(made.color_variance.at(1, 0)[0], 20.0 / 3 / 4, 1e-6);
    EXPECT_EQ(made.count.at(0, 0)[0], 2);
    EXPECT_EQ(made.count.at(1, 0)[0], 4);
    EXPECT_EQ(made.features.channels(), 0);
}

TEST(PixelFeatures, variance_is_unbiased) {
    constexpr size_t pixels = 20000;
    for (const size_t spp : {size_t(2), size_t(5)}) {
        std::vector<float> rgb;
        for (size_t i = 0; i < 3 * spp * pixels; ++i) rgb.push_back(10 + 3 * normal_at(i, spp));
        const Made made =
            features_of(make_samples(200, 100, std::vector<size_t>(pixels, spp), std::move(rgb)));
        double mean = 0;
        for (float v : made.color_variance.pixels()) mean += double(v) / (3 * pixels);
        EXPECT_NEAR(mean, 9.0 / double(spp), 0.02 * 9.0 / double(spp));
    }
}

TEST(PixelFeatures, weights_count_as_so_many_samples_would_in_the_mean) {
    Samples s = make_samples(1, 1, {3}, {1, 0, 0, 5, 0, 0, 100, 0, 0});
    s.add("weight", 1, {3, 1, nan});
    const Made made = features_of(s);
    EXPECT_EQ(made.color.at(0, 0)[0], 2);
    // sum w^2 (x - m)^2 = 9 + 9; (sum w)^2 - sum w^2 = 16 - 10.
    EXPECT_NEAR(made.color_variance.at(0, 0)[0], 3, 1e-6);
    EXPECT_EQ(made.count.at(0, 0)[0], 2);
}

TEST(PixelFeatures, a_single_sample_takes_the_deviation_of_its_3_x_3_pixels) {
    std::vector<float> rgb;
    for (size_t i = 0; i < 25; ++i) rgb.insert(rgb.end(), {i == 12 ? 9.0f : 0.0f, 1, 2});
    const Made made = features_of(make_samples(5, 5, std::vector<size_t>(25, 1), rgb));
    EXPECT_EQ(made.color.at(2, 2)[0], 9);
    // Nine samples, one of them 9: sample variance (81 - 9) / 8.
    EXPECT_NEAR(made.color_variance.at(2, 2)[0], 9, 1e-6);
    EXPECT_NEAR(made.color_variance.at(1, 1)[0], 9, 1e-6);
    EXPECT_EQ(made.color_variance.at(0, 0)[1], 0);
    EXPECT_EQ(made.color_variance.at(4, 0)[0], 0);
    const Made alone = features_of(make_samples(1, 1, {1}, {3, 4, 5}));
    EXPECT_EQ(alone.color.at(0, 0)[2], 5);
    EXPECT_EQ(alone.color_variance.at(0, 0)[2], 0);
}

TEST(PixelFeatures, a_pixel_without_samples_is_0_and_counted_so) {
    const Made made = features_of(make_samples(3, 1, {1, 0, 2}, {1, 1, 1, 2, 2, 2, 4, 4, 4}));
    EXPECT_EQ(made.count.at(1, 0)[0], 0);
    EXPECT_EQ(made.color.at(1, 0)[0], 0);
    EXPECT_EQ(made.color_variance.at(1, 0)[0], 0);
    ASSERT_EQ(made.warnings.size(), 1u);
    EXPECT_EQ(made.warnings[0], "1 of 3 pixels have no sample; they are 0, and 'count' is");
}

TEST(PixelFeatures, samples_that_are_not_finite_are_dropped_and_counted) {
    const Made made = features_of(make_samples(2, 1, {2, 2}, {1, 1, 1, 3, 3, 3, nan, 0, 0, 5, 5, 5},
                                               {0, 0, 1, 0, 1, 0, 1, 0, 0, 0, -infinity, 0}));
    EXPECT_EQ(made.color.at(1, 0)[1], 5);
    EXPECT_EQ(made.count.at(1, 0)[0], 1);
    EXPECT_EQ(made.features.names(),
              (std::vector<std::string>{"normal.x", "normal.y", "normal.z"}));
    EXPECT_EQ(made.features.at(1, 0)[0], 1);
    ASSERT_EQ(made.warnings.size(), 2u);
    EXPECT_EQ(made.warnings[0],
              "rgb: 1 samples are not finite and left out; first: pixel (1, 0), sample 0");
    EXPECT_EQ(made.warnings[1],
              "normal: 1 samples are not finite and left out; first: pixel (1, 0), sample 1");
}

TEST(PixelFeatures, depth_of_the_background_is_infinite_and_no_fault) {
    Samples s = make_samples(2, 1, {2, 2}, std::vector<float>(12, 1));
    s.add("z", 1, {infinity, infinity, 3, infinity});
    const Made made = features_of(s, {"z"});
    EXPECT_EQ(made.features.names(), std::vector<std::string>{"z"});
    EXPECT_EQ(made.features.at(0, 0)[0], infinity);
    EXPECT_EQ(made.features.at(1, 0)[0], 3);
    EXPECT_TRUE(made.warnings.empty());
}

TEST(PixelFeatures, roles_choose_the_layers_and_names_override_them) {
    Samples s = make_samples(1, 1, {2}, std::vector<float>(6, 1), {0, 0, 1, 0, 0, 1});
    s.add(Channel{"curvature", 1, Role::feature, Array<float>(std::vector<float>{1, 3}), {}});
    s.add("roughness", 1, {0.5f, 0.7f});
    EXPECT_EQ(features_of(s).features.names(),
              (std::vector<std::string>{"normal.x", "normal.y", "normal.z", "curvature"}));
    const Made asked = features_of(s, {"roughness"});
    EXPECT_EQ(asked.features.names(), std::vector<std::string>{"roughness"});
    EXPECT_NEAR(asked.features.at(0, 0)[0], 0.6f, 1e-6);
    s.add_ids("id", {1, 2});
    EXPECT_NE(error_of([&] { features_of(s, {"id"}); }).find("whole numbers"), std::string::npos);
    EXPECT_NE(error_of([&] { features_of(s, {"albedo"}); }).find("needs albedo"),
              std::string::npos);
}

}  // namespace
}  // namespace weft
