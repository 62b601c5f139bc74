// pixel-filter's kernel: against its scalar form, and against pictures with known answers.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "filters/pixel_filter_kernel.h"
#include "tests/sample_buffer.h"

namespace weft {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

float random_number(size_t i, size_t what) {
    return unit_float(mix(i * 97 + what * 1000003));
}

// Samples whose rgb is value(x, y) times 1, 2 and -1; count_of(pixel) samples each.
Samples make_samples(int width, int height, const std::function<size_t(size_t)>& count_of,
                     const std::function<float(float, float)>& value) {
    Samples s = placed_samples(width, height, count_of, [](size_t i) {
        return std::array{0.999f * random_number(i, 1), 0.999f * random_number(i, 2)};
    });
    std::vector<float> rgb;
    for (size_t i = 0; i < s.size(); ++i) {
        const float v = value(s.xy()[2 * i], s.xy()[2 * i + 1]);
        rgb.insert(rgb.end(), {v, 2 * v, -v});
    }
    s.add("rgb", 3, std::move(rgb));
    return s;
}
size_t four(size_t) {
    return 4;
}

std::vector<float> filtered(const Samples& s, const PixelFilter& filter,
                            const char* channel = "rgb", size_t* missing = nullptr) {
    const auto in = kernel::filter_input(s, {s.find(channel)});
    std::vector<float> out(s.pixels() * size_t(in.components()));
    const size_t m = kernel::filter_rows(in, filter, 0, s.height, out.data());
    if (missing) *missing = m;
    return out;
}
std::vector<PixelFilter> all_filters() {
    std::vector<PixelFilter> filters;
    for (size_t i = 0; i < filter_names().size(); ++i)
        filters.push_back(make_filter({.kind = FilterKind(i)}));
    filters.push_back(BoxFilter{.radius = 1.2f});
    filters.push_back(GaussianFilter{.radius = 0.4f, .sigma = 0.3f});
    return filters;
}

TEST(PixelFilter, fast_rows_equal_the_scalar_form_bit_for_bit_in_any_bands) {
    Samples s = make_samples(
        23, 17, [](size_t p) { return size_t(p * 7 % 5); },
        [](float x, float y) { return std::sin(x * 3) + y; });
    std::vector<float> weight;
    for (size_t i = 0; i < s.size(); ++i)
        weight.push_back(i % 11 == 0 ? 0.0f : random_number(i, 3));
    s.add("weight", 1, weight);
    for (const PixelFilter& filter : all_filters()) {
        const auto in = kernel::filter_input(s, {s.find("rgb")});
        const std::vector<float> whole = filtered(s, filter);
        for (int band : {1, 5, 17})
            for (int y = 0; y < s.height; y += band) {
                const int end = std::min(y + band, s.height);
                std::vector<float> rows(size_t(end - y) * size_t(s.width) * 3);
                kernel::filter_rows(in, filter, y, end, rows.data());
                for (size_t i = 0; i < rows.size(); ++i)
                    ASSERT_EQ(rows[i], whole[size_t(y) * size_t(s.width) * 3 + i])
                        << filter.index();
            }
        for (int y = 0; y < s.height; ++y)
            for (int x = 0; x < s.width; ++x) {
                float pixel[3];
                kernel::filter_pixel(in, filter, x, y, pixel);
                for (int c = 0; c < 3; ++c)
                    ASSERT_EQ(pixel[c],
                              whole[(size_t(y) * size_t(s.width) + size_t(x)) * 3 + size_t(c)])
                        << filter.index() << " at " << x << ", " << y;
            }
    }
}

TEST(PixelFilter, a_constant_stays_constant) {
    const Samples s = make_samples(
        16, 9, [](size_t) { return size_t(32); }, [](float, float) { return 0.37f; });
    for (const PixelFilter& filter : all_filters()) {
        const auto picture = filtered(s, filter);
        for (size_t i = 0; i < picture.size(); i += 3) {
            EXPECT_NEAR(picture[i], 0.37f, 1e-6);
            EXPECT_NEAR(picture[i + 1], 0.74f, 1e-6);
            EXPECT_NEAR(picture[i + 2], -0.37f, 1e-6);
        }
    }
}

TEST(PixelFilter, box_is_the_mean_of_the_pixels_own_samples) {
    const Samples s = make_samples(8, 5, four, [](float x, float y) { return x * y; });
    const auto picture = filtered(s, BoxFilter{});
    for (size_t p = 0; p < s.pixels(); ++p) {
        double mean = 0;
        for (size_t k = 0; k < 4; ++k) mean += double(s.rgb()[3 * (4 * p + k)]) / 4;
        EXPECT_NEAR(picture[3 * p], mean, 1e-5);
    }
}

// On a regular grid an even filter keeps a ramp as it is, away from the border.
TEST(PixelFilter, a_ramp_stays_a_ramp) {
    constexpr int n = 8;
    Samples s = make_samples(
        20, 20, [](size_t) { return size_t(n * n); }, [](float, float) { return 0.0f; });
    std::vector<float> xy, rgb;
    for (size_t p = 0; p < s.pixels(); ++p)
        for (int k = 0; k < n * n; ++k) {
            const float x = float(p % 20) + (float(k % n) + 0.5f) / n,
                        y = float(p / 20) + (float(k / n) + 0.5f) / n;
            xy.insert(xy.end(), {x, y});
            rgb.insert(rgb.end(), {x, y, 2 * x - y});
        }
    Samples ramp;
    ramp.width = ramp.height = 20, ramp.spp = n * n;
    ramp.set_size(s.size());
    ramp.add("xy", 2, std::move(xy));
    ramp.add("rgb", 3, std::move(rgb));
    for (const PixelFilter& filter : all_filters()) {
        const auto picture = filtered(ramp, filter);
        for (size_t y = 4; y < 16; ++y)
            for (size_t x = 4; x < 16; ++x) {
                EXPECT_NEAR(picture[3 * (y * 20 + x)], float(x) + 0.5f, 2e-2) << filter.index();
                EXPECT_NEAR(picture[3 * (y * 20 + x) + 1], float(y) + 0.5f, 2e-2) << filter.index();
            }
    }
}

TEST(PixelFilter, negative_lobes_sharpen_a_step) {
    const Samples s = make_samples(
        24, 8, [](size_t) { return size_t(64); },
        [](float x, float) { return x < 12 ? 0.0f : 1.0f; });
    const auto over = [&](const PixelFilter& filter) {
        float most = 0;
        for (size_t i = 0; const float v : filtered(s, filter))
            if (i++ % 3 == 0) most = std::max(most, v);
        return most;
    };
    EXPECT_LE(over(TentFilter{}), 1.00001f);
    EXPECT_GT(over(MitchellFilter{}), 1.005f);
    EXPECT_GT(over(LanczosFilter{}), 1.02f);
}

TEST(PixelFilter, one_pixel_picture) {
    const Samples s = make_samples(1, 1, four, [](float, float) { return 0.5f; });
    for (const PixelFilter& filter : all_filters()) {
        const auto picture = filtered(s, filter);
        EXPECT_NEAR(picture[0], 0.5f, 1e-6);
    }
}

TEST(PixelFilter, no_samples_at_all_give_zeros_and_a_count) {
    const Samples s = make_samples(
        4, 3, [](size_t) { return size_t(0); }, [](float, float) { return 1.0f; });
    for (const PixelFilter& filter : all_filters()) {
        size_t missing = 0;
        for (float v : filtered(s, filter, "rgb", &missing)) EXPECT_EQ(v, 0);
        EXPECT_EQ(missing, 12u);
    }
}

TEST(PixelFilter, an_empty_pixel_is_filled_by_wider_filters_only) {
    const Samples s = make_samples(
        5, 5, [](size_t p) { return p == 12 ? size_t(0) : size_t(8); },
        [](float, float) { return 1.0f; });
    size_t missing = 0;
    EXPECT_EQ(filtered(s, BoxFilter{}, "rgb", &missing)[36], 0);
    EXPECT_EQ(missing, 1u);
    EXPECT_NEAR((filtered(s, TentFilter{.radius = 1.5f}, "rgb", &missing)[36]), 1, 1e-6);
    EXPECT_EQ(missing, 0u);
}

TEST(PixelFilter, samples_that_are_not_finite_are_left_out) {
    Samples s = make_samples(3, 3, four, [](float, float) { return 1.0f; });
    std::vector<float> rgb(s.rgb().begin(), s.rgb().end());
    rgb[3 * 16] = nan, rgb[3 * 17 + 1] = infinity, rgb[3 * 18 + 2] = -infinity;
    Samples bad;
    bad.width = bad.height = 3, bad.spp = 4;
    bad.set_size(s.size());
    bad.add("xy", 2, std::vector<float>(s.xy().begin(), s.xy().end()));
    bad.add("rgb", 3, std::move(rgb));
    for (const PixelFilter& filter : all_filters())
        for (float v : filtered(bad, filter)) EXPECT_TRUE(std::isfinite(v));
    EXPECT_NEAR(filtered(bad, BoxFilter{})[12], 1,
                1e-6);  // of the one good sample in the middle pixel
}

TEST(PixelFilter, depth_is_infinite_only_where_every_sample_is) {
    Samples s = make_samples(2, 1, four, [](float, float) { return 1.0f; });
    s.add("z", 1, {infinity, infinity, infinity, infinity, 2, infinity, 4, nan});
    const auto depth = filtered(s, BoxFilter{}, "z");
    EXPECT_EQ(depth[0], infinity);
    EXPECT_EQ(depth[1], 3);
}

TEST(PixelFilter, weights_of_samples_count_and_bad_ones_are_left_out) {
    Samples s = make_samples(1, 1, four, [](float, float) { return 0.0f; });
    s.add("value", 1, {1, 2, 100, 200});
    s.add("weight", 1, {3, 1, nan, -5});
    EXPECT_NEAR(filtered(s, BoxFilter{}, "value")[0], (3 * 1 + 1 * 2) / 4.0, 1e-6);
}

TEST(PixelFilter, a_sample_outside_its_own_pixel_counts_where_it_lies) {
    Samples s;
    s.width = 3, s.height = 1, s.spp = 1;
    s.set_size(3);
    s.add("xy", 2,
          {1.4f, 0.5f, 1.6f, 0.5f, 2.5f, 0.5f});  // the first belongs to pixel 0 by its index
    s.add("rgb", 3, {1, 1, 1, 3, 3, 3, 5, 5, 5});
    size_t missing = 0;
    const auto picture = filtered(s, BoxFilter{}, "rgb", &missing);
    EXPECT_EQ(picture[0], 0);
    EXPECT_EQ(picture[3], 2);
    EXPECT_EQ(picture[6], 5);
    EXPECT_EQ(missing, 1u);
}

TEST(PixelFilter, nearest_takes_one_sample_untouched) {
    const Samples s = make_samples(9, 7, four, [](float x, float y) { return x + 100 * y; });
    const auto in = kernel::filter_input(s, {s.find("rgb")});
    std::vector<float> picture(s.pixels() * 3);
    EXPECT_EQ(kernel::nearest_rows(in, 0, s.height, picture.data()), 0u);
    for (size_t p = 0; p < s.pixels(); ++p) {
        const float cx = float(p % 9) + 0.5f, cy = float(p / 9) + 0.5f;
        float best = infinity, value = 0;
        for (size_t i = 0; i < s.size(); ++i) {
            const float d = std::hypot(s.xy()[2 * i] - cx, s.xy()[2 * i + 1] - cy);
            if (d < best) best = d, value = s.rgb()[3 * i];
        }
        EXPECT_EQ(picture[3 * p], value);
    }
}

}  // namespace
}  // namespace weft
