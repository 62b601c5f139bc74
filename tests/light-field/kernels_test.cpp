// The fast kernels against their scalar forms, on every instruction set of this processor.
#include "light-field/build_hierarchy_kernel.h"
#include "light-field/kernels.h"
#include "light-field/points.h"
#include "light-field/reference_kernels.h"
#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {
using namespace light_field;

// Locations of an 8 x 8 block, shared or each with its own (u, v, t).
Locations locations_in(int x0, int y0, bool shared, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    Locations at;
    at.shared = shared;
    at.x0 = x0, at.y0 = y0, at.x1 = x0 + 8, at.y1 = y0 + 8;
    const auto point = [&] {
        const auto uv = on_lens(unit(random), unit(random), Lens{});
        at.u.push_back(uv[0]);
        at.v.push_back(uv[1]);
        at.t.push_back(unit(random));
    };
    if (shared) point();
    for (int i = 0; i < 64; ++i) {
        at.x.push_back(float(x0 + i % 8) + unit(random));
        at.y.push_back(float(y0 + i / 8) + unit(random));
        at.own_pixels.push_back(std::uint32_t(i));
        if (!shared) point();
    }
    at.pixels = at.own_pixels;
    return at;
}

class Kernels : public testing::TestWithParam<std::tuple<Isa, Kind_of, bool>> {
  protected:
    void SetUp() override {
        const auto [isa, kind, shared] = GetParam();
        pinned = std::make_unique<PinnedIsa>(isa);
        h = build_hierarchy(random_samples(32, 24, 4, kind), Arrangement::layers, 1, ctx);
    }
    // Candidates within radius, by the fast way.
    Candidates candidates(const Locations& at, float radius) {
        Candidates c;
        c.pixels = at.pixels;
        Block block;
        collect(h, at.x0, at.y0, at.x1, at.y1, radius, block);
        if (at.shared) {
            Projection p;
            WEFT_PICK(project)(h, block, at.u[0], at.v[0], at.t[0], false, p);
            WEFT_PICK(gather)(p, at, radius, c);
        } else {
            WEFT_PICK(gather_each)(h, block, at, radius, c);
        }
        return c;
    }
    std::vector<reference::Seen> seen(const Candidates& c, size_t l) const {
        std::vector<reference::Seen> all;
        for (size_t i = c.offset[l]; i < c.offset[l + 1]; ++i) all.push_back(reference::see(h, c.sample[i], c.u_of(l), c.v_of(l), c.t_of(l)));
        return all;
    }
    PlainContext ctx;
    std::unique_ptr<PinnedIsa> pinned;
    Hierarchy h;
};

TEST_P(Kernels, GatherFindsTheSamplesThatBruteForceFinds) {
    const bool shared = std::get<2>(GetParam());
    for (unsigned trial = 0; trial < 12; ++trial)
        for (float radius : {h.radius, 2 * h.radius}) {
            const Locations at = locations_in(int(trial % 4) * 8, int(trial % 3) * 8, shared, trial);
            const Candidates c = candidates(at, radius);
            for (size_t l = 0; l < at.size(); ++l) {
                std::vector<std::uint32_t> found(c.sample.begin() + c.offset[l], c.sample.begin() + c.offset[l + 1]);
                std::sort(found.begin(), found.end());
                const auto inner = reference::near(h, at.x[l], at.y[l], at.u_of(l), at.v_of(l), at.t_of(l), radius * 0.9999f);
                const auto outer = reference::near(h, at.x[l], at.y[l], at.u_of(l), at.v_of(l), at.t_of(l), radius * 1.0001f);
                ASSERT_TRUE(std::includes(found.begin(), found.end(), inner.begin(), inner.end())) << "location " << l;
                ASSERT_TRUE(std::includes(outer.begin(), outer.end(), found.begin(), found.end())) << "location " << l;
                for (size_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
                    const reference::Seen s = reference::see(h, c.sample[i], at.u_of(l), at.v_of(l), at.t_of(l));
                    ASSERT_NEAR(c.dx[i], s.x - at.x[l], 2e-3f);
                    ASSERT_NEAR(c.dy[i], s.y - at.y[l], 2e-3f);
                }
            }
        }
}

TEST_P(Kernels, SpreadBoundsSlopesAndVelocities) {
    const Locations at = locations_in(8, 8, std::get<2>(GetParam()), 3);
    const Candidates c = candidates(at, h.radius);
    size_t known = 0;
    for (size_t l = 0; l < at.size(); ++l) {
        if (c.spread[l] == 0xffffffffu) continue;
        ++known;
        const auto all = seen(c, l);
        for (const auto& a : all)
            for (const auto& b : all) {
                EXPECT_LE(std::abs(a.slope_y - b.slope_y), (float(c.spread[l] & 255) + 1.01f) * c.slope_step);
                EXPECT_LE(std::abs(a.velocity_x - b.velocity_x), (float(c.spread[l] >> 8 & 255) + 1.01f) * c.velocity_step);
                EXPECT_LE(std::abs(a.velocity_y - b.velocity_y), (float(c.spread[l] >> 16 & 255) + 1.01f) * c.velocity_step);
            }
    }
    if (std::get<1>(GetParam()) != Kind_of::moving_in_depth) {
        EXPECT_GT(known, 0u);
    }
}

TEST_P(Kernels, ClustersAreThoseOfTheScalarForm) {
    const SameSurface test{0.0884f, 0.1f};
    ClusterScratch scratch;
    size_t several = 0, differ = 0, all = 0;
    for (unsigned trial = 0; trial < 6; ++trial) {
        const Locations at = locations_in(8, 8, std::get<2>(GetParam()), trial);
        const Candidates c = candidates(at, (trial % 2 ? 2 : 1) * h.radius);
        Surfaces s;
        s.pixels = at.pixels;
        WEFT_PICK(cluster)(c, test, scratch, s);
        for (size_t l = 0; l < at.size(); ++l) {
            const auto expected = reference::cluster(seen(c, l), test);
            const std::vector<std::uint16_t> found(s.surface.begin() + c.offset[l], s.surface.begin() + c.offset[l + 1]);
            const size_t count = expected.empty() ? 0 : size_t(*std::max_element(expected.begin(), expected.end())) + 1;
            several += count > 1;
            ++all;
            differ += found != expected || s.count_of[l] != count;  // by rounding at a test's limit
        }
    }
    EXPECT_LE(differ, all / 100);
    if (std::get<1>(GetParam()) != Kind_of::still_pinhole) {
        EXPECT_GT(several, 20u);
    }
}

TEST_P(Kernels, CoverageSharesALocationAmongSurfacesAsTheScalarFormDoes) {
    ClusterScratch cluster_scratch;
    CoverageScratch scratch;
    std::array<size_t, 6> decisions{};
    for (unsigned trial = 0; trial < 4; ++trial) {
        const Locations at = locations_in(8, 8, std::get<2>(GetParam()), trial);
        const Candidates c = candidates(at, 2 * h.radius);
        Surfaces s;
        Visibility v;
        s.pixels = v.pixels = at.pixels;
        WEFT_PICK(cluster)(c, SameSurface{}, cluster_scratch, s);
        WEFT_PICK(cover_finally)(c, s, h.radius, scratch, v);
        size_t part = 0;
        for (size_t l = 0; l < at.size(); ++l) {
            ++decisions[size_t(v.decision[l])];
            if (s.count_of[l] < 2) continue;
            const size_t first = c.offset[l], n = c.of(l);
            const std::vector<float> expected = reference::shares({&c.dx[first], n}, {&c.dy[first], n}, {&s.surface[first], n},
                                                                  s.count_of[l], h.radius, float(h.mean_spp));
            std::vector<float> share(s.count_of[l], 0.0f);
            v.each_seen(l, part, [&](std::uint16_t from, std::uint16_t to, float seen) {
                EXPECT_EQ(from, to);
                share[from] += seen;
            });
            for (size_t k = 0; k < share.size(); ++k) EXPECT_NEAR(share[k], expected[k], 1e-4) << "location " << l;
        }
        EXPECT_EQ(part, v.parts.size());
    }
    if (std::get<1>(GetParam()) == Kind_of::defocused) {
        EXPECT_GT(decisions[size_t(Decision::covered)], 0u);
    }
    if (std::get<1>(GetParam()) == Kind_of::moving_in_depth) {
        EXPECT_GT(decisions[size_t(Decision::partly)], 0u);
    }
}

INSTANTIATE_TEST_SUITE_P(All, Kernels,
                         testing::Combine(testing::ValuesIn(instruction_sets()),
                                          testing::Values(Kind_of::still_pinhole, Kind_of::defocused, Kind_of::moving, Kind_of::moving_in_depth),
                                          testing::Bool()));

// Spreads are in steps. A step so coarse that two surfaces fall into one says nothing of them.
TEST(Cluster, TwoSurfacesWithinOneCoarseStepAreToldApart) {
    Hierarchy h;
    h.lens = {-20, 4};
    h.X = {0, 0};
    h.Y = {0, 0};
    h.W = {1, 5};  // slopes -16 and 0
    Candidates c;
    std::vector<std::uint32_t> pixel{0};
    c.pixels = pixel;
    c.hierarchy = &h;
    c.offset = {0, 2};
    c.dx = {-0.05f, 0.05f};
    c.dy = {0, 0};
    c.sample = {0, 1};
    for (auto* places : {&c.dx, &c.dy}) places->resize(32);
    c.sample.resize(32);
    c.x = c.y = c.u = c.v = {0};
    c.t = {0.5f};
    c.spread = {0};
    c.slope_step = 20;
    for (Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        ClusterScratch scratch;
        Surfaces s;
        s.pixels = pixel;
        WEFT_PICK(cluster)(c, SameSurface{0.0884f, 0.1f}, scratch, s);
        EXPECT_EQ(s.count_of[0], 2);
        EXPECT_EQ(s.surface[1], 1);
    }
}

// One location, two surfaces: candidates at these places in front, one far behind.
struct TwoSurfaces {
    Hierarchy h;
    Candidates c;
    Surfaces s;
    std::vector<std::uint32_t> pixel{0};
    TwoSurfaces(const std::vector<float>& x, const std::vector<float>& y) {
        h.radius = 1;
        const size_t n = x.size();
        c.hierarchy = &h;
        c.offset = {0, std::uint32_t(n + 1)};
        c.dx = x;
        c.dy = y;
        c.dx.push_back(0.9f);
        c.dy.push_back(0.9f);
        c.dx.resize(n + 32);
        c.dy.resize(n + 32);
        s.surface.assign(n + 32, 0);
        s.surface[n] = 1;
        s.count_of = {2};
        c.pixels = s.pixels = pixel;
    }
};

TEST(Coverage, OfRandomPointsIsThatOfTheScalarForm) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> place(-2, 2);
    for (Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        CoverageScratch scratch;
        size_t covered = 0;
        for (int trial = 0; trial < 3000; ++trial) {
            const size_t n = trial % 100 == 99 ? 60 : 4 + size_t(trial % 9);
            std::vector<float> x, y;
            while (x.size() < n) {
                const float px = place(random), py = place(random);
                if (px * px + py * py >= 4) continue;
                x.push_back(px);
                y.push_back(py);
            }
            TwoSurfaces two(x, y);
            Visibility v;
            v.pixels = two.pixel;
            WEFT_PICK(cover_finally)(two.c, two.s, 1, scratch, v);
            const bool expected = reference::surrounded(x, y, 1);
            ASSERT_EQ(v.decision[0] == Decision::covered, expected) << "trial " << trial;
            covered += expected;
            v.decision.clear();
            WEFT_PICK(cover)(two.c, two.s, 1, v);
            ASSERT_EQ(v.decision[0] == Decision::covered, reference::hull_holds_origin(x, y)) << "trial " << trial;
        }
        EXPECT_GT(covered, 300u);
        EXPECT_LT(covered, 2700u);
    }
}

TEST(Coverage, AThinSurfaceIsSeenByThePartItCovers) {
    // Three samples of the 50 that would be there; a surface that covers all has weights of pi spp / 6 in all.
    const std::vector<float> x{0.1f, -0.1f, 0.5f}, y{0.1f, 0.1f, -0.2f};
    for (Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        TwoSurfaces two(x, y);
        two.h.mean_spp = 4;
        two.h.rgba = {9, 9, 9, 1, 9, 9, 9, 1, 9, 9, 9, 1, 1, 1, 1, 1};
        CoverageScratch scratch;
        Visibility v;
        v.pixels = two.pixel;
        WEFT_PICK(cover_finally)(two.c, two.s, 1, scratch, v);
        double weights = 0;
        for (size_t i = 0; i < x.size(); ++i) weights += std::pow(1 - std::hypot(double(x[i]), double(y[i])), 2);
        const double share = weights / (3.14159265 * 4 / 6);
        ASSERT_LT(share, 1);
        ASSERT_EQ(v.decision[0], Decision::partly);
        ASSERT_EQ(v.parts.size(), 2u);
        EXPECT_EQ(v.parts[0].surface, 0);
        EXPECT_NEAR(v.parts[0].share, share, 1e-5);
        EXPECT_EQ(v.parts[1].surface, 1);
        EXPECT_NEAR(v.parts[1].share, 1 - share, 1e-5);

        two.c.sample = {0, 1, 2, 3};
        two.c.sample.resize(32);
        FilterScratch filter_scratch;
        Colors colors;
        WEFT_PICK(filter)(two.c, two.s, v, Tent{2, 2}, filter_scratch, colors);
        ASSERT_TRUE(colors.valid[0]);
        EXPECT_NEAR(colors.rgba[0], share * 9 + (1 - share) * 1, 1e-4);
        EXPECT_NEAR(colors.rgba[3], 1, 1e-5);
    }
}

TEST(Coverage, AThinSurfaceDoesNotSurroundAtFirstSight) {
    // Its hull holds the location, but it has 3 samples where there is room for 12.
    for (Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        TwoSurfaces two({0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, -0.5f});
        Visibility v;
        v.pixels = two.pixel;
        two.h.mean_spp = 4;
        WEFT_PICK(cover)(two.c, two.s, 1, v);
        EXPECT_EQ(v.decision[0], Decision::undecided);
        two.h.mean_spp = 2;
        WEFT_PICK(cover)(two.c, two.s, 1, v);
        EXPECT_EQ(v.decision[0], Decision::covered);
    }
}

TEST(Filter, WeighsTheSamplesOfTheSurfaceSeen) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(-1, 1), light(0, 2);
    for (Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        for (float exponent : {1.0f, 2.0f, 2.5f, 4.0f})
            for (size_t n : {1u, 3u, 7u, 8u, 9u, 40u}) {
                Hierarchy h;
                h.radius = 0.8f;
                std::vector<float> x, y;
                for (size_t i = 0; i < n; ++i) x.push_back(place(random)), y.push_back(place(random));
                TwoSurfaces two(x, y);
                for (size_t i = 0; i < 4 * (n + 1); ++i) h.rgba.push_back(light(random));
                two.c.hierarchy = &h;
                two.c.sample.resize(n + 32);
                for (size_t i = 0; i <= n; ++i) two.c.sample[i] = std::uint32_t(i);
                Visibility v;
                v.first = v.last = {0};
                v.decision = {Decision::covered};
                FilterScratch scratch;
                Colors colors;
                WEFT_PICK(filter)(two.c, two.s, v, Tent{h.radius, exponent}, scratch, colors);
                double sum[5] = {}, nearest = 1e9;
                size_t at = 0;
                for (size_t i = 0; i < n; ++i) {
                    const double d = std::hypot(double(x[i]), double(y[i])), w = std::pow(std::max(0.0, 1 - d / h.radius), double(exponent));
                    for (size_t k = 0; k < 4; ++k) sum[k] += w * h.rgba[4 * i + k];
                    sum[4] += w;
                    if (d < nearest) nearest = d, at = i;
                }
                ASSERT_TRUE(colors.valid[0]);
                for (size_t k = 0; k < 4; ++k)
                    EXPECT_NEAR(colors.rgba[k], sum[4] > 0 ? sum[k] / sum[4] : double(h.rgba[4 * at + k]), 2e-5) << exponent << " " << n;
            }
    }
}

}  // namespace
}  // namespace weft
