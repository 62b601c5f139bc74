// Points at which to reconstruct cover pixel, lens and shutter evenly.
#include "light-field/points.h"
#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {
using namespace light_field;

TEST(Points, LieOnTheLensAndInTheShutter) {
    for (int blades : {0, 3, 5, 8}) {
        Lens lens{-1, 1};
        lens.blades = blades;
        lens.rotation = 0.3f;
        for (std::uint32_t i = 0; i < 512; ++i) {
            const LensPoint p = lens_point(9, i, 512, lens);
            EXPECT_LE(p.u * p.u + p.v * p.v, 1.00001f);
            EXPECT_GE(p.t, 0);
            EXPECT_LT(p.t, 1);
            if (blades < 3) continue;
            // Within every edge of the polygon.
            const float step = 6.2831853f / float(blades), inner = std::cos(step / 2);
            for (int k = 0; k < blades; ++k) {
                const float a = lens.rotation + (float(k) + 0.5f) * step;
                EXPECT_LE(p.u * std::cos(a) + p.v * std::sin(a), inner + 1e-4f);
            }
        }
    }
}

TEST(Points, CoverTheDiskEvenly) {
    constexpr std::uint32_t n = 256;
    std::array<int, 4> rings{}, quadrants{};
    double mean[3] = {};
    for (std::uint32_t i = 0; i < n; ++i) {
        const LensPoint p = lens_point(4, i, n, Lens{-1, 1});
        ++rings[std::min<size_t>(3, size_t(4 * (p.u * p.u + p.v * p.v)))];  // rings of equal area
        ++quadrants[size_t(p.u > 0) + 2 * size_t(p.v > 0)];
        mean[0] += p.u, mean[1] += p.v, mean[2] += p.t;
    }
    for (int count : rings) EXPECT_NEAR(count, n / 4, 10);
    for (int count : quadrants) EXPECT_NEAR(count, n / 4, 6);
    EXPECT_NEAR(mean[0] / n, 0, 0.02);
    EXPECT_NEAR(mean[1] / n, 0, 0.02);
    EXPECT_NEAR(mean[2] / n, 0.5, 0.01);
}

TEST(Points, OfAPixelAreStratifiedHoweverScrambled) {
    for (int pixel = 0; pixel < 20; ++pixel) {
        const std::uint64_t key = pixel_scramble(1, pixel, 2 * pixel);
        std::array<int, 64> cells{};
        for (std::uint32_t i = 0; i < 64; ++i) {
            const auto pattern = pixel_pattern(i);
            const float x = unit_float(pattern[0] ^ std::uint32_t(key)), y = unit_float(pattern[1] ^ std::uint32_t(key >> 32));
            ASSERT_GE(x, 0);
            ASSERT_LT(x, 1);
            ++cells[size_t(x * 8) + 8 * size_t(y * 8)];
        }
        EXPECT_GT(64 - std::count(cells.begin(), cells.end(), 0), 30);
    }
}

}  // namespace
}  // namespace weft
