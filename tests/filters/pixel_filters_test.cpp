// The filter family: shapes, support, symmetry, known values.
#include "filters/pixel_filters.h"

#include <gtest/gtest.h>

namespace weft {
namespace {

constexpr float odd_radii[] = {0.5f, 0.7f, 1.0f, 1.9f, 3.3f};

std::vector<PixelFilter> all_filters(float width = 0) {
    std::vector<PixelFilter> filters;
    for (size_t i = 0; i < filter_names().size(); ++i)
        filters.push_back(make_filter({.kind = FilterKind(i), .width = width}));
    return filters;
}

double integral(const PixelFilter& filter) {
    const double r = double(radius_of(filter));
    constexpr int n = 20000;
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += double(evaluate(filter, float(-r + (i + 0.5) * 2 * r / n)));
    return sum * 2 * r / n;
}

TEST(PixelFilters, weights_are_zero_past_the_radius) {
    for (float radius : odd_radii)
        for (const PixelFilter& filter : all_filters(2 * radius)) {
            EXPECT_EQ(radius_of(filter), radius);
            for (float past : {1e-4f, 0.1f, 2.0f, 100.0f}) {
                EXPECT_EQ(evaluate(filter, radius + past), 0) << filter.index();
                EXPECT_EQ(evaluate(filter, -radius - past), 0) << filter.index();
            }
            EXPECT_GT(evaluate(filter, 0), 0) << filter.index();
        }
}

TEST(PixelFilters, all_are_even) {
    for (const PixelFilter& filter : all_filters())
        for (float d = 0; d < 4; d += 0.0713f)
            EXPECT_EQ(evaluate(filter, d), evaluate(filter, -d)) << filter.index();
}

TEST(PixelFilters, all_but_the_box_end_without_a_step) {
    for (float width : {0.0f, 1.3f, 5.0f})
        for (const PixelFilter& filter : all_filters(width)) {
            if (std::holds_alternative<BoxFilter>(filter)) continue;
            if (std::holds_alternative<LanczosFilter>(filter) && width != 0)
                continue;  // tau says where
            EXPECT_LT(std::fabs(evaluate(filter, radius_of(filter) * 0.9999f)), 2e-3f)
                << filter.index();
        }
}

TEST(PixelFilters, boxes_one_pixel_wide_share_no_point) {
    const BoxFilter box;
    for (float x : {0.0f, 0.25f, 0.5f, 0.999f, 1.0f}) {
        float covered = 0;
        for (int pixel = -2; pixel <= 2; ++pixel)
            covered += box.evaluate(x - (float(pixel) + 0.5f));
        EXPECT_EQ(covered, 1) << x;
    }
}

TEST(PixelFilters, tent_and_mitchell_sum_to_one_over_whole_pixels) {
    const PixelFilter partitions[] = {TentFilter{}, MitchellFilter{},
                                      MitchellFilter{.b = 1, .c = 0},
                                      MitchellFilter{.b = 0, .c = 0.5f}};
    for (const PixelFilter& filter : partitions)
        for (float shift : {0.0f, 0.1f, 0.37f, 0.5f, 0.93f}) {
            float sum = 0;
            for (int i = -4; i <= 4; ++i) sum += evaluate(filter, float(i) + shift);
            EXPECT_NEAR(sum, 1, 1e-5) << filter.index() << " at " << shift;
        }
}

TEST(PixelFilters, values_of_the_literature) {
    // Mitchell and Netravali's own choice is 8/9 at the centre and 1/18 a pixel away; the B-spline
    // 2/3 and 1/6; Catmull-Rom interpolates.
    EXPECT_NEAR(MitchellFilter{}.evaluate(0), 8.0 / 9, 1e-6);
    EXPECT_NEAR(MitchellFilter{}.evaluate(1), 1.0 / 18, 1e-6);
    EXPECT_NEAR((MitchellFilter{.b = 1, .c = 0}.evaluate(0)), 2.0 / 3, 1e-6);
    EXPECT_NEAR((MitchellFilter{.b = 1, .c = 0}.evaluate(1)), 1.0 / 6, 1e-6);
    EXPECT_NEAR((MitchellFilter{.b = 0, .c = 0.5f}.evaluate(1)), 0, 1e-6);
    // A sinc is 1 at 0 and 0 at every other whole number; at 1/2 it is 2/pi, its window there 3/pi.
    EXPECT_EQ(LanczosFilter{}.evaluate(0), 1);
    EXPECT_NEAR(LanczosFilter{}.evaluate(1), 0, 1e-6);
    EXPECT_NEAR(LanczosFilter{}.evaluate(2), 0, 1e-6);
    EXPECT_NEAR(LanczosFilter{}.evaluate(0.5f), 2 / std::numbers::pi * 3 / std::numbers::pi, 1e-6);
    EXPECT_NEAR(BlackmanHarrisFilter{}.evaluate(0), 1, 1e-6);
    EXPECT_NEAR((GaussianFilter{.radius = 10, .sigma = 2}.evaluate(2)),
                std::exp(-0.5) - std::exp(-12.5), 1e-6);
    EXPECT_NEAR(integral(BlackmanHarrisFilter{}), 0.35875 * 3,
                1e-4);  // the mean term times the width
    EXPECT_NEAR(integral(TentFilter{.radius = 2}), 2, 1e-4);
}

TEST(PixelFilters, mitchell_and_lanczos_have_negative_lobes_the_others_none) {
    for (const PixelFilter& filter : all_filters()) {
        float least = 0;
        for (float d = 0; d < 4; d += 0.01f) least = std::min(least, evaluate(filter, d));
        const bool lobes = std::holds_alternative<MitchellFilter>(filter) ||
                           std::holds_alternative<LanczosFilter>(filter);
        EXPECT_EQ(least < -0.01f, lobes) << filter.index();
    }
}

}  // namespace
}  // namespace weft
