// The lens's outline and the shutter's curve.
#include "samples/lens_shape.h"

#include <gtest/gtest.h>

#include <cmath>

namespace weft {
namespace {

TEST(ShutterCurve, times_come_as_often_as_it_is_open) {
    const std::vector<float> open{0, 2, 1, 0, 0, 1};
    const ShutterCurve curve(open);
    constexpr int n = 200000, bins = 50;
    std::vector<double> seen(bins, 0);
    for (int i = 0; i < n; ++i) {
        const float t = curve.time((float(i) + 0.5f) / n);
        ASSERT_GE(t, 0);
        ASSERT_LT(t, 1);
        ++seen[size_t(t * bins)];
    }
    for (int b = 0; b < bins; ++b) {
        double expected = 0;
        for (int k = 0; k < 100; ++k)
            expected += double(curve.openness((float(b) + (float(k) + 0.5f) / 100) / bins)) / 100;
        EXPECT_NEAR(seen[size_t(b)] * bins / n, expected, 0.01) << b;
    }
}

TEST(ShutterCurve, without_shape_leaves_times_alone) {
    for (const std::vector<float>& open : {std::vector<float>{}, std::vector<float>{1},
                                           std::vector<float>{0, 0}, std::vector<float>{2, 2, 2}}) {
        const ShutterCurve curve(open);
        EXPECT_TRUE(curve.constant());
        EXPECT_EQ(curve.time(0.37f), 0.37f);
        EXPECT_EQ(curve.openness(0.37f), 1);
    }
}

TEST(ShutterCurve, is_read_from_meta) {
    Json meta = Json::object();
    EXPECT_TRUE(shutter_of(meta).constant());
    meta.set("shutter_curve", Json());
    EXPECT_TRUE(shutter_of(meta).constant());
    meta.set("shutter_curve", Json::list({0.0, 1.0, 0.0}));
    EXPECT_NEAR(shutter_of(meta).openness(0.5f), 2, 1e-6f);
}

TEST(Lens, blades_make_a_polygon_of_even_points) {
    Lens lens;
    lens.blades = 6;
    lens.rotation = 0.3f;
    double inside = 0;
    constexpr int n = 400;
    const float apothem = std::cos(3.14159265f / 6);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const auto [u, v] = on_lens((float(i) + 0.5f) / n, (float(j) + 0.5f) / n, lens);
            for (int k = 0; k < 6; ++k) {
                const float a = 0.3f + (float(k) + 0.5f) * 3.14159265f / 3;
                ASSERT_LE(u * std::cos(a) + v * std::sin(a), apothem + 1e-5f);
            }
            inside += u * u + v * v < 0.25f;
        }
    // A disc of half the radius: pi / 4 of the hexagon's 3 sqrt(3) / 2.
    EXPECT_NEAR(inside / (n * n), 3.14159265 / 4 / (1.5 * std::sqrt(3.0)), 2e-3);
}

}  // namespace
}  // namespace weft
