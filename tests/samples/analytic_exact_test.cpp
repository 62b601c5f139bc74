// Scenes with exact answers: brute force against closed form.
#include <gtest/gtest.h>

#include <cmath>

#include "graph/error.h"
#include "samples/analytic_known.h"
#include "samples/analytic_scene.h"

namespace weft {
namespace {

constexpr const char* known[] = {"step", "plane", "disc", "layers"};

// Root mean square of brute force less exact, over all pixels and colours.
double rms_error(const char* scene, const AnalyticOptions& o, int spp) {
    PlainContext ctx;
    const Image picture = analytic_reference(scene, o, spp, ctx);
    double sum = 0;
    for (int y = 0; y < o.height; ++y)
        for (int x = 0; x < o.width; ++x) {
            const auto exact = analytic_exact(scene, o, x, y);
            for (size_t c = 0; c < 3; ++c)
                sum += std::pow(double(picture.at(x, y)[c]) - exact->at(c), 2);
        }
    return std::sqrt(sum / (3 * o.width * o.height));
}

TEST(AnalyticExact, brute_force_meets_the_closed_form_at_monte_carlo_rate) {
    for (Sampler sampler : {Sampler::independent, Sampler::stratified, Sampler::sobol})
        for (const char* scene : known) {
            const AnalyticOptions o{.width = 24, .height = 24, .sampler = sampler};
            const double coarse = rms_error(scene, o, 64), fine = rms_error(scene, o, 1024);
            EXPECT_LT(fine, std::string(scene) == "disc" ? 0.03 : 0.02) << scene;
            EXPECT_LT(fine, coarse * 0.36) << scene;  // 1/4 for independent samples
        }
}

TEST(AnalyticExact, pinhole_and_still_are_exact_too) {
    for (const char* scene : known) {
        const AnalyticOptions o{.width = 24, .height = 24, .aperture = 0, .shutter = 0};
        EXPECT_LT(rms_error(scene, o, 256), 0.06) << scene;
    }
}

TEST(AnalyticExact, exact_pictures_have_what_they_are_named_for) {
    const AnalyticOptions o{.width = 64, .height = 64};
    // The step's edge moves 8 pixels: strictly between bright and dark in between, not outside.
    const auto far_left = *analytic_exact("step", o, 2, 5),
               far_right = *analytic_exact("step", o, 60, 5);
    EXPECT_NEAR(far_left[0], 0.9, 1e-6);
    EXPECT_NEAR(far_right[0], 0.05, 1e-6);
    const auto between = *analytic_exact("step", o, 32, 5);
    EXPECT_GT(between[0], 0.2);
    EXPECT_LT(between[0], 0.8);
    // All of the light arrives: radiance times the area of the disc on the film.
    double sum = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) sum += analytic_exact("disc", o, x, y)->at(0);
    const double radius = 64 * 0.25 / 12;
    EXPECT_NEAR(sum, 8 * 3.14159265 * radius * radius, 0.01 * sum);
    EXPECT_FALSE(analytic_exact("garden", o, 0, 0).has_value());
}

TEST(AnalyticExact, shares_of_disks) {
    EXPECT_NEAR(analytic::disk_below(0), 0.5, 1e-12);
    EXPECT_EQ(analytic::disk_below(-2), 0);
    EXPECT_EQ(analytic::disk_below(2), 1);
    EXPECT_NEAR(analytic::common_area(1, 2, 0), 3.14159265, 1e-6);
    EXPECT_EQ(analytic::common_area(1, 2, 3), 0);
    EXPECT_NEAR(analytic::common_area(1, 1, 1), 2 * 3.14159265 / 3 - std::sqrt(3.0) / 2, 1e-6);
    EXPECT_NEAR(analytic::common_area(1, 100, 100), 3.14159265 / 2, 0.01);  // half of it, nearly
}

TEST(AnalyticExact, an_unknown_scene_names_those_there_are) {
    PlainContext ctx;
    try {
        analytic_samples("gardn", {}, ctx);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("'gardn'"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("garden"), std::string::npos);
    }
    EXPECT_THROW(analytic_samples("garden", {.width = 0}, ctx), Error);
    EXPECT_THROW(analytic_samples("garden", {.spp = 0}, ctx), Error);
    EXPECT_THROW(analytic_samples("garden", {.aperture = -1}, ctx), Error);
}

}  // namespace
}  // namespace weft
