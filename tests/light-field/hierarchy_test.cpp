// Bounds of groups hold their samples over lens and shutter; a search finds all that can be seen.
#include <algorithm>
#include <atomic>
#include <numeric>
#include <thread>

#include "light-field/build_hierarchy_kernel.h"
#include "light-field/reference_kernels.h"
#include "light-field/sample_order.h"
#include "samples/file_bytes.h"
#include "samples/sample_file.h"
#include "tests/light-field/light_field_test.h"
#include "tests/mapped_bytes.h"

namespace weft {
namespace {
using namespace light_field;

class HierarchyOf : public testing::TestWithParam<std::tuple<Kind_of, Arrangement>> {
  protected:
    PlainContext ctx;
    std::mt19937 random{7};
    float between(float a, float b) { return std::uniform_real_distribution<float>(a, b)(random); }
};

TEST_P(HierarchyOf, EverySampleLiesWithinItsGroupsBounds) {
    const auto [kind, arrangement] = GetParam();
    const Hierarchy h = build_hierarchy(random_samples(24, 20, 3, kind), arrangement, 1, ctx);
    for (int trial = 0; trial < 300; ++trial) {
        const float a = between(0, 6.3f), r = trial % 3 ? std::sqrt(between(0, 1)) : 1.0f;
        const float u = r * std::cos(a), v = r * std::sin(a),
                    t = trial % 5 ? between(0, 1) : float(trial % 2);
        for (size_t i = 0; i < h.size(); ++i) {
            const reference::Seen s = reference::see(h, i, u, v, t);
            if (!s.there) continue;
            const size_t g = i / Hierarchy::group_size;
            const float x =
                h.groups.slope[g] * h.lens.aspect * u + h.groups.velocity_x[g] * (t - 0.5f);
            const float y = h.groups.slope[g] * v + h.groups.velocity_y[g] * (t - 0.5f);
            ASSERT_GE(s.x, h.groups.x_low[g] + x) << "sample " << i << " of " << h.size();
            ASSERT_LE(s.x, h.groups.x_high[g] + x);
            ASSERT_GE(s.y, h.groups.y_low[g] + y);
            ASSERT_LE(s.y, h.groups.y_high[g] + y);
        }
    }
}

TEST_P(HierarchyOf, SearchFindsWhateverCanBeSeenInARectangle) {
    const auto [kind, arrangement] = GetParam();
    const Hierarchy h = build_hierarchy(random_samples(40, 30, 4, kind), arrangement, 1, ctx);
    for (int trial = 0; trial < 40; ++trial) {
        const float x0 = between(-5, 35), y0 = between(-5, 25), x1 = x0 + between(0, 9),
                    y1 = y0 + between(0, 9);
        std::vector<std::uint32_t> groups;
        h.collect(x0, y0, x1, y1, groups);
        EXPECT_TRUE(std::is_sorted(groups.begin(), groups.end()));
        const float u = between(-0.7f, 0.7f), v = between(-0.7f, 0.7f), t = between(0, 1);
        for (size_t i = 0; i < h.size(); ++i) {
            const reference::Seen s = reference::see(h, i, u, v, t);
            if (!s.there || s.x < x0 || s.x > x1 || s.y < y0 || s.y > y1) continue;
            ASSERT_TRUE(std::binary_search(groups.begin(), groups.end(),
                                           std::uint32_t(i / Hierarchy::group_size)));
        }
    }
}

TEST_P(HierarchyOf, HoldsEverySampleOnceWithItsRadiance) {
    const auto [kind, arrangement] = GetParam();
    const Samples samples = random_samples(9, 7, 2, kind);
    const Hierarchy h = build_hierarchy(samples, arrangement, 1, ctx);
    ASSERT_EQ(h.size(), samples.size());
    EXPECT_EQ(h.W.size() % Hierarchy::group_size, 0u);
    std::vector<int> seen(samples.size());
    for (size_t i = 0; i < h.size(); ++i) {
        ++seen[h.order[i]];
        for (size_t c = 0; c < 3; ++c)
            EXPECT_EQ(h.rgba[4 * i + c], samples.rgb()[3 * h.order[i] + c]);
        // At its own lens position and time it is where it was.
        const auto uv = samples.uv(), t = samples.t();
        const size_t j = h.order[i];
        const reference::Seen s =
            reference::see(h, i, uv.empty() ? 0 : uv[2 * j], uv.empty() ? 0 : uv[2 * j + 1],
                           t.empty() ? 0.5f : t[j]);
        ASSERT_TRUE(s.there);
        EXPECT_NEAR(s.x, samples.xy()[2 * j], 2e-3f);
        EXPECT_NEAR(s.y, samples.xy()[2 * j + 1], 2e-3f);
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ptrdiff_t(seen.size()));
}

INSTANTIATE_TEST_SUITE_P(
    All, HierarchyOf,
    testing::Combine(testing::Values(Kind_of::still_pinhole, Kind_of::defocused, Kind_of::moving,
                                     Kind_of::moving_in_depth),
                     testing::Values(Arrangement::layers, Arrangement::cells)));

// Pieces of a loop on four threads, in whatever order.
struct FourThreads : PlainContext {
    void parallel(size_t count, size_t grain,
                  const std::function<void(size_t, size_t)>& work) override {
        std::atomic<size_t> next = 0;
        std::vector<std::jthread> threads;
        for (int i = 0; i < 4; ++i)
            threads.emplace_back([&] {
                for (size_t begin; (begin = next.fetch_add(grain)) < count;)
                    work(begin, std::min(count, begin + grain));
            });
    }
};

TEST(SampleOrder, IsThatOfAStableSortOnAnyThreads) {
    std::mt19937_64 random(3);
    for (const std::uint64_t range : {std::uint64_t(1), std::uint64_t(40), std::uint64_t(1) << 20,
                                      std::uint64_t(1) << 42, std::uint64_t(1) << 52})
        for (const size_t n : {size_t(0), size_t(1), size_t(2), size_t(1000), size_t(300000)}) {
            LargeArray<std::uint64_t> keys(n);
            // Every other one near the one before, as samples of a pixel are.
            for (size_t i = 0; i < n; ++i)
                keys[i] = 77 + (i % 2 ? std::min(keys[i - 1] - 77 + random() % 3, range - 1)
                                      : random() % range);
            std::vector<std::uint32_t> expected(n);
            std::iota(expected.begin(), expected.end(), 0u);
            std::stable_sort(expected.begin(), expected.end(),
                             [&](auto a, auto b) { return keys[a] < keys[b]; });
            FourThreads threads;
            const auto order = sorted(keys, threads);
            ASSERT_TRUE(std::equal(order.begin(), order.end(), expected.begin(), expected.end()))
                << range << ' ' << n;
        }
}

TEST(Hierarchy, OfAnEmptyBufferFindsNothing) {
    PlainContext ctx;
    Samples none;
    none.width = none.height = 4;
    none.spp = 1;
    none.add("xy", 2, {});
    none.add("z", 1, {});
    none.add("rgb", 3, {});
    const Hierarchy h = build_hierarchy(none, Arrangement::layers, 1, ctx);
    std::vector<std::uint32_t> groups;
    h.collect(-1e9f, -1e9f, 1e9f, 1e9f, groups);
    EXPECT_TRUE(groups.empty());
    EXPECT_EQ(h.size(), 0u);
}

TEST(Hierarchy, NamesTheChannelThatIsMissing) {
    PlainContext ctx;
    Samples flat;
    flat.width = flat.height = 1;
    flat.spp = 1;
    flat.add("xy", 2, {0.5f, 0.5f});
    flat.add("rgb", 3, {1, 1, 1});
    EXPECT_NE(error_of([&] { build_hierarchy(flat, Arrangement::layers, 1, ctx); }).find("needs z"),
              std::string::npos);
}

TEST(Hierarchy, RadiusHalvesWhenSamplesQuadruple) {
    EXPECT_NEAR(dispersion_radius(1), 2, 0.05);
    EXPECT_NEAR(dispersion_radius(16) / dispersion_radius(64), 2, 0.05);
    EXPECT_LT(dispersion_radius(3), dispersion_radius(2.5));
}

TEST(Hierarchy, OfAMappedFileLetsGoOfItAndIsTheSame) {
    if (mapped_bytes() < 0) GTEST_SKIP() << "no RssFile in /proc/self/status";
    const Samples samples = random_samples(640, 400, 2, Kind_of::moving_in_depth);
    const TestFolder folder;
    PlainContext ctx;
    const Hierarchy expected = build_hierarchy(samples, Arrangement::layers, 1, ctx);
    const std::string file = saved(folder, samples);
    const Samples mapped = read_sample_file(map_file(file), {}, ctx);
    const double before = mapped_bytes();
    const Hierarchy h = build_hierarchy(mapped, Arrangement::layers, 1, ctx);
    // (Reading has looked at all of it already, for checksums. What is left is where channels meet.)
    EXPECT_LT(mapped_bytes() - before, -0.8 * 48 * double(samples.size()));
    const auto expect_equal = [](const auto& a, const auto& b) { EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end())); };
    expect_equal(h.order, expected.order);
    expect_equal(h.X, expected.X);
    expect_equal(h.paths, expected.paths);
    expect_equal(h.rgba, expected.rgba);
    expect_equal(mapped.rgb(), samples.rgb());
    expect_equal(mapped.motion(), samples.motion());
}

TEST(ForgetPages, LeavesMemoryThatIsNoMappedFile) {
    std::vector<float> values(1 << 20);
    std::iota(values.begin(), values.end(), 0.0f);
    forget_pages(values);
    for (size_t i = 0; i < values.size(); i += 997) ASSERT_EQ(values[i], float(i));
}

}  // namespace
}  // namespace weft
