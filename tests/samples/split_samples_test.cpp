// split-samples: every sample in one half, each pixel's by turns.
#include <algorithm>

#include "samples/samples.h"
#include "tests/run_node.h"

namespace weft {
namespace {

// Sample i has t = i and id i.
Samples buffer(int width, int height, const std::vector<size_t>& counts) {
    Samples samples;
    samples.width = width, samples.height = height;
    std::vector<std::uint64_t> first{0};
    for (const size_t n : counts) first.push_back(first.back() + n);
    samples.set_size(first.back());
    std::vector<float> t(first.back());
    std::vector<std::uint32_t> id(first.back());
    for (size_t i = 0; i < t.size(); ++i) t[i] = float(i), id[i] = std::uint32_t(i);
    const bool even =
        std::all_of(counts.begin(), counts.end(), [&](size_t n) { return n == counts[0]; });
    samples.spp = even ? int(counts[0]) : 0;
    if (!even) samples.first = std::move(first);
    samples.add("t", 1, std::move(t));
    samples.add_ids("id", std::move(id));
    return samples;
}
std::vector<float> of(const Samples& samples, size_t pixel) {
    const auto [begin, end] = samples.of_pixel(pixel);
    return {samples.t().begin() + std::ptrdiff_t(begin), samples.t().begin() + std::ptrdiff_t(end)};
}
struct Halves {
    Samples first, second;
    std::vector<std::string> warnings;
};
Halves split(const Samples& samples) {
    Halves halves;
    RunNode node("split-samples");
    node.in("samples", samples)
        .run({{"first", &type_info<Samples>(), &halves.first, {}},
              {"second", &type_info<Samples>(), &halves.second, {}}});
    halves.warnings = node.ctx.warnings;
    return halves;
}

TEST(SplitSamples, gives_each_half_every_other_sample_of_a_pixel) {
    const Halves halves = split(buffer(2, 1, {4, 4}));
    EXPECT_EQ(halves.first.spp, 2);
    EXPECT_TRUE(halves.first.first.empty());
    EXPECT_EQ(of(halves.first, 0), (std::vector<float>{0, 2}));
    EXPECT_EQ(of(halves.second, 0), (std::vector<float>{1, 3}));
    EXPECT_EQ(of(halves.first, 1), (std::vector<float>{5, 7}));
    EXPECT_EQ(of(halves.second, 1), (std::vector<float>{4, 6}));
    EXPECT_EQ(halves.second.find("id")->ids[1], 3u);
    EXPECT_EQ(halves.second.find("id")->components, 1);
}

TEST(SplitSamples, shares_odd_samples_out_as_on_a_chessboard) {
    const Samples samples = buffer(2, 2, {1, 1, 1, 1});
    const Halves halves = split(samples);
    EXPECT_EQ(halves.first.spp, 0);
    EXPECT_EQ(halves.first.size(), 2u);
    EXPECT_EQ(halves.second.size(), 2u);
    EXPECT_EQ(of(halves.first, 0), (std::vector<float>{0}));
    EXPECT_TRUE(of(halves.first, 1).empty());
    EXPECT_TRUE(of(halves.first, 2).empty());
    EXPECT_EQ(of(halves.first, 3), (std::vector<float>{3}));
    EXPECT_EQ(of(halves.second, 1), (std::vector<float>{1}));
}

TEST(SplitSamples, warns_of_pixels_that_only_one_half_knows) {
    EXPECT_TRUE(split(buffer(3, 1, {2, 3, 0})).warnings.empty());
    const std::vector<std::string> warnings = split(buffer(3, 1, {1, 3, 1})).warnings;
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(warnings[0].starts_with("2 of 3 pixels have one sample"));
}

TEST(SplitSamples, loses_no_sample_and_doubles_none_however_many_there_are) {
    const std::vector<size_t> counts = {3, 0, 7, 1, 2, 5};
    const Samples samples = buffer(3, 2, counts);
    const Halves halves = split(samples);
    for (size_t pixel = 0; pixel < counts.size(); ++pixel) {
        std::vector<float> all = of(halves.first, pixel);
        const std::vector<float> others = of(halves.second, pixel);
        EXPECT_LE(std::max(all.size(), others.size()), std::min(all.size(), others.size()) + 1);
        all.insert(all.end(), others.begin(), others.end());
        std::sort(all.begin(), all.end());
        EXPECT_EQ(all, of(samples, pixel)) << pixel;
    }
}

TEST(SplitSamples, needs_pixels) {
    Samples samples = buffer(1, 1, {2});
    samples.domain = "light";
    EXPECT_NE(error_of([&] { split(samples); }).find("domain 'light'"), std::string::npos);
}

}  // namespace
}  // namespace weft
