// cross-validate: the share of least error, where that is known.
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "image/image.h"
#include "samples/random.h"
#include "tests/run_node.h"

namespace weft {
namespace {

constexpr int width = 96, height = 80;
using Value = std::function<float(int x, int y)>;

Image picture(const Value& value, int channels = 3) {
    Image image(width, height, channels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c) image.at(x, y)[c] = value(x, y);
    return image;
}
Value always(float v) {
    return [=](int, int) { return v; };
}
// The same in all channels, of deviation 1.
Value noise(std::uint64_t seed) {
    return [=](int x, int y) {
        const std::uint64_t bits = mix(seed ^ mix(std::uint64_t(y * width + x)));
        return std::sqrt(12.0f) * (unit_float(std::uint32_t(bits)) - 0.5f);
    };
}

struct Case {
    Value low = always(1), high = always(2), mean = always(1);
    Value second_low{}, second_high{}, second_mean{};  // those of the first, if not given
    Value count = always(4);
};
Image share(const Case& by, std::vector<std::pair<std::string, double>> set = {}) {
    const auto or_first = [](const Value& second, const Value& first) {
        return second ? second : first;
    };
    const std::vector<std::pair<std::string, Image>> pictures = {
        {"first-low", picture(by.low)},
        {"first-high", picture(by.high)},
        {"first-mean", picture(by.mean)},
        {"first-count", picture(by.count, 1)},
        {"second-low", picture(or_first(by.second_low, by.low))},
        {"second-high", picture(or_first(by.second_high, by.high))},
        {"second-mean", picture(or_first(by.second_mean, by.mean))},
        {"second-count", picture(by.count, 1)},
    };
    RunNode node("cross-validate");
    for (const auto& [port, image] : pictures) node.in(port, image);
    for (const auto& [name, value] : set) node.set(name, value);
    return node.out<Image>("share");
}

TEST(CrossValidate, takes_the_picture_that_samples_agree_with_or_what_lies_between) {
    for (const float expected : {0.0f, 0.25f, 1.0f}) {
        const Image s = share({.mean = always(1 + expected)});
        EXPECT_EQ(s.channels(), 1);
        for (const int x : {0, 50, width - 1}) EXPECT_NEAR(*s.at(x, x % height), expected, 1e-5f);
    }
    // Past either there is nothing to take.
    EXPECT_EQ(*share({.mean = always(7)}).at(5, 5), 1.0f);
    EXPECT_EQ(*share({.mean = always(-7)}).at(5, 5), 0.0f);
}

// One picture is off by b, the other noisy by v, the samples' means by more: the error of
// low + s (high - low) is (1 - s)^2 b^2 + s^2 v, the least at b^2 / (b^2 + v).
TEST(CrossValidate, mixes_a_biased_picture_and_a_noisy_one_by_their_errors) {
    const auto noisy = [](std::uint64_t seed, float deviation, float off) -> Value {
        return [=](int x, int y) { return 1 + off + deviation * noise(seed)(x, y); };
    };
    for (const float b : {0.05f, 0.1f, 0.2f}) {
        const Image s = share({.low = always(1 + b),
                               .high = noisy(1, 0.1f, 0),
                               .mean = noisy(2, 0.15f, 0),
                               .second_low = always(1 + b),
                               .second_high = noisy(3, 0.1f, 0),
                               .second_mean = noisy(4, 0.15f, 0)},
                              {{"sigma", 16}, {"limit", 1e6}});
        const auto all = s.pixels();
        const double mean = std::accumulate(all.begin(), all.end(), 0.0) / double(all.size());
        EXPECT_NEAR(mean, b * b / (b * b + 0.01f), 0.04) << b;
    }
}

TEST(CrossValidate, lets_no_firefly_decide) {
    const Value fireflies = [](int x, int y) { return x % 16 == 3 && y % 16 == 5 ? 1e6f : 1.0f; };
    EXPECT_LT(*share({.mean = fireflies}).at(50, 40), 0.05f);
    EXPECT_GT(*share({.mean = fireflies}, {{"limit", 1e6}}).at(50, 40), 0.5f);
}

TEST(CrossValidate, goes_by_what_is_near) {
    const Image s =
        share({.mean = [](int x, int) { return x < width / 2 ? 1.0f : 2.0f; }}, {{"wide", 4}});
    EXPECT_LT(*s.at(width / 2 - 12, 40), 0.01f);
    EXPECT_GT(*s.at(width / 2 + 12, 40), 0.99f);
}

TEST(CrossValidate, knows_nothing_where_a_half_has_no_samples_or_what_it_has_is_not_finite) {
    EXPECT_EQ(*share({.count = always(0)}).at(9, 9), 0.0f);
    EXPECT_NEAR(*share({.count = always(0)}, {{"otherwise", 0.7}}).at(9, 9), 0.7f, 1e-6f);
    // Half of the pixels say 2, but have no samples.
    const auto half = [](float a, float b) -> Value {
        return [=](int x, int y) { return (x + y) % 2 ? a : b; };
    };
    EXPECT_NEAR(*share({.mean = half(1.25f, 2), .count = half(1, 0)}).at(30, 30), 0.25f, 1e-4f);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_NEAR(*share({.mean = half(1.25f, nan)}).at(30, 30), 0.25f, 1e-4f);
    EXPECT_NEAR(*share({.high = half(2, nan), .mean = always(1.25f)}).at(30, 30), 0.25f, 1e-4f);
}

TEST(CrossValidate, does_not_depend_on_the_unit_of_light) {
    const auto lit = [](float unit) {
        const auto by = [=](std::uint64_t seed) -> Value {
            return [=](int x, int y) { return unit * (2 + 0.3f * noise(seed)(x, y)); };
        };
        return share({.low = by(1), .high = by(2), .mean = by(3)});
    };
    const Image one = lit(1), other = lit(1024);
    for (int x = 0; x < width; x += 7) EXPECT_NEAR(*one.at(x, 33), *other.at(x, 33), 1e-5f);
}

TEST(CrossValidate, wants_pictures_of_one_size) {
    const Image three(4, 4, 3), one(4, 4, 1), wider(5, 4, 1);
    RunNode node("cross-validate");
    for (const std::string half : {"first", "second"}) {
        for (const char* port : {"-low", "-high", "-mean"}) node.in(half + port, three);
        node.in(half + "-count", half == "second" ? wider : one);
    }
    EXPECT_NE(error_of([&] { node.run(); }).find("5 x 4 with 1 channels beside 4 x 4"),
              std::string::npos);
}

}  // namespace
}  // namespace weft
