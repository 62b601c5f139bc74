// What holds of every filter from picture to picture, and what each is for.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "filters/pictures.h"
#include "runtime/executor.h"
#include "tests/instruction_sets.h"
#include "tests/run_node.h"

namespace weft {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
const std::vector<std::string> rgb = {"R", "G", "B"};

// A filter's inputs; what it has no port for is not linked.
struct Scene {
    Image image;
    std::optional<Image> variance, features, features_variance, mask;

    Image filtered(const std::string& type,
                   const std::vector<std::pair<std::string, Json>>& set = {},
                   std::vector<std::string>* warnings = nullptr) const {
        RunNode node(type);
        node.in("image", image);
        const NodeDecl& decl = Registry::instance().type(type)->decl();
        const auto link = [&](const char* port, const std::optional<Image>& value) {
            if (value && decl.find_input(port) >= 0) node.in(port, *value);
        };
        link("variance", variance);
        link("features", features);
        link("features-variance", features_variance);
        link("mask", mask);
        for (const auto& [name, value] : set) node.set(name, value);
        Image out = node.out<Image>("image");
        if (warnings) *warnings = node.ctx.warnings;
        return out;
    }
};

std::vector<float> values_of(const Image& image) {
    return {image.pixels().begin(), image.pixels().end()};
}

// A noisy step between two levels, at x = width / 2; the feature shows it without noise.
Scene step_scene(int width, int height, float low, float high, float noise) {
    Scene s;
    const auto level = [&](int x) { return x < width / 2 ? low : high; };
    s.image = make_picture(width, height, rgb, [&](int x, int y, int c) {
        return level(x) + noise * normal_at(size_t((y * 1000 + x) * 3 + c), 7);
    });
    s.image.color_space = "lin_rec709";
    s.variance = make_picture(width, height, rgb, [&](int, int, int) { return noise * noise; });
    s.features = make_picture(width, height, {"normal.x"},
                              [&](int x, int, int) { return x < width / 2 ? 0.0f : 1.0f; });
    s.features_variance = Image(width, height, {"normal.x"});
    return s;
}

double rmse(const Image& a, const std::function<float(int x)>& truth) {
    double sum = 0;
    for (int y = 0; y < a.height(); ++y)
        for (int x = 0; x < a.width(); ++x)
            for (int c = 0; c < 3; ++c) sum += std::pow(double(a.at(x, y)[c]) - truth(x), 2);
    return std::sqrt(sum / double(a.pixels().size()));
}

class ImageFilter : public testing::TestWithParam<const char*> {
  public:
    std::string type = GetParam();
};

TEST_P(ImageFilter, a_constant_stays_constant) {
    Scene s = step_scene(40, 30, 0.37f, 0.37f, 0);
    s.variance = random_picture(40, 30, rgb, 1, 0.1f);
    for (const float v : values_of(s.filtered(type))) EXPECT_NEAR(v, 0.37f, 1e-6);
}

TEST_P(ImageFilter, keeps_names_spaces_and_attributes) {
    Scene s;
    s.image = random_picture(12, 9, {"A", "B", "G", "R"}, 3);
    s.image.color_space = "ACEScg";
    s.image.attributes["owner"] = "us";
    const Image out = s.filtered(type);
    EXPECT_EQ(out.names(), s.image.names());
    EXPECT_EQ(out.color_space, "ACEScg");
    EXPECT_EQ(out.attributes, s.image.attributes);
}

TEST_P(ImageFilter, takes_away_noise_on_flat_ground) {
    const Scene s = step_scene(64, 64, 0.5f, 0.5f, 0.1f);
    const auto truth = [](int) { return 0.5f; };
    EXPECT_LT(rmse(s.filtered(type), truth), 0.5 * rmse(s.image, truth));
}

TEST_P(ImageFilter, stays_within_the_values_it_is_given) {
    const Scene s = step_scene(33, 21, 1, 2, 0.5f);
    const auto [least, most] =
        std::minmax_element(s.image.pixels().begin(), s.image.pixels().end());
    for (const float v : values_of(s.filtered(type))) {
        EXPECT_GE(v, *least - 1e-5f);
        EXPECT_LE(v, *most + 1e-5f);
    }
}

TEST_P(ImageFilter, a_mirrored_picture_gives_the_mirrored_result) {
    Scene s = step_scene(37, 23, 0.2f, 0.8f, 0.2f);
    s.features = random_picture(37, 23, {"normal.x"}, 9);
    s.features_variance = random_picture(37, 23, {"normal.x"}, 10, 0.1f);
    s.mask = make_picture(37, 23, {"Y"},
                          [](int x, int y, int) { return (x + 5 * y) % 13 == 0 ? 0.0f : 2.0f; });
    Scene m = s;
    for (auto* image : {&m.variance, &m.features, &m.features_variance, &m.mask})
        *image = mirrored(**image);
    m.image = mirrored(s.image);
    const Image there = mirrored(s.filtered(type)), here = m.filtered(type);
    for (size_t i = 0; i < here.pixels().size(); ++i)
        EXPECT_NEAR(here.pixels()[i], there.pixels()[i], 1e-5);
}

TEST_P(ImageFilter, pictures_of_a_pixel_or_a_row_and_windows_larger_than_the_picture) {
    for (const auto& [width, height] : {std::pair(1, 1), {17, 1}, {1, 17}, {2, 2}, {3, 5}}) {
        const Scene s = step_scene(width, height, 0.5f, 0.5f, 0.1f);
        const Image out = s.filtered(type);
        for (const float v : out.pixels()) EXPECT_TRUE(std::isfinite(v));
        if (width * height == 1) {
            EXPECT_NEAR(out.at(0, 0)[1], s.image.at(0, 0)[1], 1e-6);
        }
    }
    Scene none;
    none.image = Image(0, 0, rgb);
    EXPECT_EQ(none.filtered(type).pixels().size(), 0u);
}

TEST_P(ImageFilter, needs_nothing_but_the_picture) {
    Scene s;
    s.image = random_picture(20, 11, rgb, 4);
    for (const float v : values_of(s.filtered(type))) EXPECT_TRUE(std::isfinite(v));
}

TEST_P(ImageFilter, pixels_that_are_not_finite_are_filled_and_lend_nothing) {
    Scene s = step_scene(30, 20, 1, 1, 0);
    s.image.at(10, 10)[0] = nan;
    s.image.at(11, 10)[1] = infinity;
    s.image.at(0, 0)[2] = -infinity;
    s.variance->at(20, 10)[0] = nan;
    s.features->at(5, 5)[0] = nan;
    std::vector<std::string> warnings;
    for (const float v : values_of(s.filtered(type, {}, &warnings))) EXPECT_NEAR(v, 1, 1e-6);
    EXPECT_TRUE(warnings.empty());
}

TEST_P(ImageFilter, masked_pixels_are_filled_and_lend_nothing) {
    for (const char* channel : {"A", "Y"}) {
        Scene s = step_scene(30, 20, 1, 1, 0);
        s.mask = make_picture(30, 20,
                              channel == std::string("A") ? std::vector<std::string>{"x", "A"}
                                                          : std::vector<std::string>{"Y"},
                              [](int, int, int) { return 1.0f; });
        const int c = s.mask->channels() - 1;
        for (const int x : {3, 4, 17}) {
            s.image.at(x, 6)[1] = 50;
            s.mask->at(x, 6)[c] = x == 4 ? nan : 0;
        }
        for (const float v : values_of(s.filtered(type))) EXPECT_NEAR(v, 1, 1e-6);
    }
}

TEST_P(ImageFilter, what_nothing_can_fill_is_0_and_said) {
    Scene s = step_scene(3, 2, 1, 1, 0);
    s.mask = Image(3, 2, {"Y"});
    std::vector<std::string> warnings;
    for (const float v : values_of(s.filtered(type, {}, &warnings))) EXPECT_EQ(v, 0);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(
        warnings[0],
        "6 of 6 pixels are masked or not finite with no other pixel within reach; they are 0");
}

TEST_P(ImageFilter, an_outlier_stays_a_number_and_far_pixels_as_they_were) {
    Scene s = step_scene(64, 64, 0.5f, 0.5f, 0.05f);
    Scene lit = s;
    for (int c = 0; c < 3; ++c) lit.image.at(2, 2)[c] = 1e12f;
    for (int c = 0; c < 3; ++c) lit.variance->at(2, 2)[c] = 1e20f;
    const std::vector<std::pair<std::string, Json>> set =
        type == "a-trous" ? std::vector<std::pair<std::string, Json>>{{"passes", Json(3)}}
                          : std::vector<std::pair<std::string, Json>>{};
    const Image out = lit.filtered(type, set), before = s.filtered(type, set);
    for (const float v : out.pixels()) EXPECT_TRUE(std::isfinite(v));
    for (int y = 32; y < 64; ++y)
        for (int x = 32; x < 64; ++x)
            for (int c = 0; c < 3; ++c) EXPECT_EQ(out.at(x, y)[c], before.at(x, y)[c]);
}

TEST_P(ImageFilter, wrong_sizes_and_channels_are_named) {
    Scene s;
    s.image = random_picture(8, 6, rgb, 1);
    s.mask = Image(8, 5, {"Y"});
    EXPECT_EQ(error_of([&] { s.filtered(type); }),
              "'mask' is 8 x 5, the picture 8 x 6; expected the same size");
    s.mask.reset();
    const NodeDecl& decl = Registry::instance().type(type)->decl();
    if (decl.find_input("variance") < 0) return;
    s.variance = Image(8, 6, {"R", "G", "X"});
    EXPECT_EQ(error_of([&] { s.filtered(type); }),
              "'variance' has no channel B; it has R G X: link what 'pixel-features' calls so");
}

// Same bits however the rows and blocks are handed out.
class BackwardContext : public PlainContext {
  public:
    void parallel(size_t count, size_t grain,
                  const std::function<void(size_t, size_t)>& work) override {
        for (size_t pieces = (count + grain - 1) / grain; pieces-- > 0;)
            work(pieces * grain, std::min(count, (pieces + 1) * grain));
    }
};

TEST_P(ImageFilter, gives_the_same_bits_in_any_order) {
    const Scene s = step_scene(300, 90, 0.2f, 0.7f, 0.2f);
    const Image forward = s.filtered(type);
    BackwardContext ctx;
    const NodeType* node = Registry::instance().type(type);
    Inputs in;
    const auto link = [&](const char* port, const Image& image) {
        auto* object = const_cast<Image*>(&image);
        if (node->decl().find_input(port) >= 0)
            in.slots.push_back({port, &type_info<Image>(), object, {object}});
    };
    link("image", s.image), link("variance", *s.variance), link("features", *s.features);
    link("features-variance", *s.features_variance);
    Image backward;
    Outputs out;
    out.slots.push_back({"image", &type_info<Image>(), &backward, {}});
    node->make(std::vector<Json>(node->decl().params.size()))->run(in, out, ctx);
    EXPECT_TRUE(std::equal(forward.pixels().begin(), forward.pixels().end(),
                           backward.pixels().begin(), backward.pixels().end()));
}

INSTANTIATE_TEST_SUITE_P(All, ImageFilter,
                         testing::Values("gaussian-filter", "bilateral-filter-image",
                                         "cross-bilateral-image", "non-local-means", "a-trous"),
                         [](const auto& type) {
                             std::string name = type.param;
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

TEST(GaussianFilter, of_a_point_is_the_gaussian) {
    Scene s;
    s.image = Image(41, 41, {"Y"});
    s.image.at(20, 20)[0] = 1;
    const Image out = s.filtered("gaussian-filter", {{"sigma", Json(2.0)}});
    double sum = 0;
    for (const float v : out.pixels()) sum += double(v);
    EXPECT_NEAR(sum, 1, 1e-5);
    EXPECT_NEAR(out.at(23, 21)[0] / out.at(20, 20)[0], std::exp(-10.0 / 8), 1e-5);
    EXPECT_EQ(out.at(27, 20)[0], 0);  // past three deviations
}

TEST(GaussianFilter, blurs_an_edge_that_the_bilateral_filter_keeps) {
    const Scene s = step_scene(60, 20, 0.1f, 0.9f, 0);
    const auto truth = [](int x) { return x < 30 ? 0.1f : 0.9f; };
    Scene plain;
    plain.image = s.image;
    EXPECT_GT(rmse(plain.filtered("gaussian-filter"), truth), 0.05);
    EXPECT_LT(rmse(plain.filtered("bilateral-filter-image"), truth), 0.002);
}

// Why the literature goes on to features: noise is an edge like any other.
TEST(BilateralFilter, keeps_noise_above_its_range_where_features_take_it_away) {
    const Scene s = step_scene(60, 60, 0.3f, 0.7f, 0.5f);
    const auto truth = [](int x) { return x < 30 ? 0.3f : 0.7f; };
    Scene plain;
    plain.image = s.image;
    const double kept = rmse(plain.filtered("bilateral-filter-image"), truth),
                 crossed = rmse(s.filtered("cross-bilateral-image"), truth);
    EXPECT_GT(kept, 0.25);
    EXPECT_LT(crossed, 0.1);
}

TEST(CrossBilateral, an_edge_of_a_feature_stays_and_one_of_no_feature_goes) {
    Scene s = step_scene(60, 20, 0.3f, 0.7f, 0);
    s.variance.reset();
    const auto truth = [](int x) { return x < 30 ? 0.3f : 0.7f; };
    EXPECT_LT(rmse(s.filtered("cross-bilateral-image"), truth), 1e-4);
    s.features.reset();
    s.features_variance.reset();
    EXPECT_GT(rmse(s.filtered("cross-bilateral-image"), truth), 0.03);
}

TEST(CrossBilateral, the_unit_of_a_feature_does_not_matter) {
    Scene s = step_scene(40, 30, 0.3f, 0.7f, 0.2f);
    s.features =
        make_picture(40, 30, {"position.x", "position.y", "position.z"}, [](int x, int y, int c) {
            return c == 0 ? float(x) : c == 1 ? float(y) : float(x * y) * 0.1f;
        });
    s.features_variance = random_picture(40, 30, s.features->names(), 5, 0.1f);
    Scene inches = s;
    for (float& v : inches.features->pixels()) v = v * 64 - 512;
    for (float& v : inches.features_variance->pixels()) v *= 64 * 64;
    const Image a = s.filtered("cross-bilateral-image"),
                b = inches.filtered("cross-bilateral-image");
    for (size_t i = 0; i < a.pixels().size(); ++i) EXPECT_NEAR(a.pixels()[i], b.pixels()[i], 1e-4);
}

TEST(CrossBilateral, a_features_own_noise_is_not_taken_for_an_edge) {
    Scene s = step_scene(60, 60, 0.5f, 0.5f, 0.2f);
    s.features = make_picture(60, 60, {"normal.x"}, [](int x, int y, int) {
        return 0.3f * normal_at(size_t(y * 100 + x), 3);
    });
    s.features_variance = make_picture(60, 60, {"normal.x"}, [](int, int, int) { return 0.09f; });
    const auto truth = [](int) { return 0.5f; };
    const double told = rmse(s.filtered("cross-bilateral-image"), truth);
    s.features.reset();
    EXPECT_LT(told, 1.1 * rmse(s.filtered("cross-bilateral-image"), truth));
}

// Seen at an angle a plane is still one surface: what passes grows with the slope.
TEST(CrossBilateral, a_tilted_plane_is_filtered_like_one_that_is_not) {
    Scene s = step_scene(60, 60, 0.5f, 0.5f, 0.2f);
    const auto truth = [](int) { return 0.5f; };
    s.features.reset();
    const double without = rmse(s.filtered("cross-bilateral-image"), truth);
    s.features_variance.reset();
    s.features = make_picture(
        60, 60, {"position.x", "position.y", "position.z"},
        [](int x, int y, int c) { return c == 0 ? 5.0f * float(x) : float(x + y * c); });
    EXPECT_LT(rmse(s.filtered("cross-bilateral-image"), truth), 1.3 * without);
    // A step in it is an edge.
    Scene cut = step_scene(60, 60, 0.3f, 0.7f, 0);
    cut.variance.reset();
    cut.features_variance.reset();
    cut.features = make_picture(
        60, 60, {"z"}, [](int x, int y, int) { return float(x + y) + (x < 30 ? 0.0f : 60.0f); });
    EXPECT_LT(
        rmse(cut.filtered("cross-bilateral-image"), [](int x) { return x < 30 ? 0.3f : 0.7f; }),
        1e-3);
}

TEST(CrossBilateral, layers_and_sigmas_are_checked) {
    Scene s = step_scene(8, 8, 0, 1, 0.1f);
    const auto error = [&](const char* name, Json value) {
        return error_of([&] { s.filtered("cross-bilateral-image", {{name, value}}); });
    };
    EXPECT_EQ(error("layers", Json::list({Json("albedo")})),
              "'features' has no layer albedo; it has normal");
    EXPECT_EQ(error("sigmas", Json::list({Json(1), Json(2)})),
              "'sigmas' has 2 values for the layers normal; expected one for all or one each");
    EXPECT_EQ(error("sigmas", Json::list({Json(0)})),
              "'sigmas' has 0 for normal; expected a number above 0");
    s.features.reset();
    EXPECT_EQ(error("layers", Json::list({Json("normal")})),
              "'layers' asks for normal, but no features are linked");
}

// Where there is no noise nothing is alike but what is equal.
TEST(NonLocalMeans, leaves_a_picture_without_noise_as_it_is) {
    Scene s;
    s.image = random_picture(30, 20, rgb, 8);
    s.variance = Image(30, 20, rgb);
    const Image out = s.filtered("non-local-means");
    for (size_t i = 0; i < out.pixels().size(); ++i)
        EXPECT_NEAR(out.pixels()[i], s.image.pixels()[i], 1e-6);
}

TEST(NonLocalMeans, keeps_an_edge_that_stands_out_of_the_noise) {
    const Scene s = step_scene(60, 40, 0.1f, 0.9f, 0.05f);
    const auto truth = [](int x) { return x < 30 ? 0.1f : 0.9f; };
    EXPECT_LT(rmse(s.filtered("non-local-means"), truth), 0.02);
}

// All differences of noise are within what passes, so that means are plain.
TEST(NonLocalMeans, on_pure_noise_is_the_mean_of_most_of_its_window) {
    const Scene s = step_scene(80, 80, 1, 1, 0.3f);
    const Image out = s.filtered("non-local-means");
    const auto truth = [](int) { return 1.0f; };
    EXPECT_LT(rmse(out, truth), 0.3 / 15 * 2);  // 0.3 / 15: of all 225 pixels
}

TEST(ATrous, reaches_as_far_as_its_passes) {
    Scene s;
    s.image = Image(129, 9, {"Y"});
    s.image.at(64, 4)[0] = 1e-3f;  // far within sigma-color
    for (const int passes : {1, 2, 3}) {
        const Image out = s.filtered("a-trous", {{"passes", Json(passes)}});
        const int reach = 2 * ((1 << passes) - 1);
        EXPECT_GT(out.at(64 + reach, 4)[0], 0) << passes;
        EXPECT_EQ(out.at(64 + reach + 1, 4)[0], 0) << passes;
    }
}

TEST(ATrous, keeps_edges_of_features_over_all_passes) {
    Scene s = step_scene(128, 64, 0.3f, 0.7f, 0.2f);
    const auto truth = [](int x) { return x < 64 ? 0.3f : 0.7f; };
    EXPECT_LT(rmse(s.filtered("a-trous"), truth), 0.04);
}

}  // namespace
}  // namespace weft
