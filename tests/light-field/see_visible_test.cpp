// see-visible against the stages that it stands for.
#include "light-field/build_hierarchy_kernel.h"
#include "light-field/kernels.h"
#include "shadows/seen_sample_kernel.h"
#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {
using namespace light_field;

// A location in each pixel of a block at one random (u, v, t).
Locations locations_in(int x0, int y0, int side, std::mt19937& random) {
    std::uniform_real_distribution<float> unit(0, 1);
    Locations at;
    at.shared = true;
    at.x0 = x0, at.y0 = y0, at.x1 = x0 + side, at.y1 = y0 + side;
    const auto uv = on_lens(unit(random), unit(random), Lens{});
    at.u = {uv[0]}, at.v = {uv[1]}, at.t = {unit(random)};
    for (int i = 0; i < side * side; ++i) {
        at.x.push_back(float(x0 + i % side) + unit(random));
        at.y.push_back(float(y0 + i / side) + unit(random));
        at.own_pixels.push_back(std::uint32_t(i));
    }
    at.pixels = at.own_pixels;
    return at;
}

// What the stages make of a batch, one after the other.
struct Stages {
    Candidates candidates;
    Surfaces surfaces;
    Visibility visibility;
    Colors colors;
    SeenSamples seen;
    Stages(const Projection& p, const Locations& at, const SeeSettings& set) {
        candidates.pixels = surfaces.pixels = visibility.pixels = colors.pixels = at.pixels;
        ClusterScratch cluster_scratch;
        CoverageScratch coverage_scratch;
        FilterScratch filter_scratch;
        WEFT_PICK(gather)(p, at, set.radius, candidates);
        WEFT_PICK(cluster)(candidates, set.test, cluster_scratch, surfaces);
        if (set.final) WEFT_PICK(cover_finally)
        (candidates, surfaces, set.cover_radius, coverage_scratch, visibility);
        else WEFT_PICK(cover)(candidates, surfaces, set.cover_radius, visibility);
        WEFT_PICK(filter)(candidates, surfaces, visibility, set.tent, filter_scratch, colors);
        seen.pixels = at.pixels;
        shadows::find_seen(candidates, surfaces, visibility, seen);
    }
};

class SeeVisible : public testing::TestWithParam<std::tuple<Isa, Kind_of, int>> {};

TEST_P(SeeVisible, SeesWhatTheStagesSee) {
    const auto [isa, kind, spp] = GetParam();
    const PinnedIsa pinned(isa);
    PlainContext ctx;
    const Hierarchy h =
        build_hierarchy(random_samples(40, 32, spp, kind), Arrangement::layers, 1, ctx);
    std::mt19937 random(unsigned(7 + spp));
    SeeScratch scratch;
    Colors colors;
    Block block;
    Projection p;
    size_t undecided = 0, covered = 0, all = 0;
    for (int trial = 0; trial < 24; ++trial) {
        const Locations at = locations_in(8 * (trial % 5), 8 * (trial % 4), 8, random);
        collect(h, at.x0, at.y0, at.x1, at.y1, 2 * h.radius, block);
        WEFT_PICK(project)(h, block, at.u[0], at.v[0], at.t[0], true, p);
        for (const bool final : {false, true})
            for (const float exponent : {1.0f, 2.0f, 4.0f}) {
                const float search = final ? 2 * h.radius : h.radius;
                const SeeSettings set{search,
                                      h.radius,
                                      {0.0884f, 0.1f},
                                      {trial % 3 ? h.radius : 0.6f * h.radius, exponent},
                                      final};
                const Stages stages(p, at, set);
                colors.pixels = at.pixels;
                std::vector<std::uint32_t> nearest(at.size());
                WEFT_PICK(see)(p, at, set, scratch, colors, nearest.data());
                EXPECT_EQ(nearest, stages.seen.sample) << "trial " << trial;
                const std::vector<float> with_nearest = colors.rgba;
                WEFT_PICK(see)(p, at, set, scratch, colors, nullptr);
                EXPECT_EQ(colors.rgba, with_nearest);
                for (size_t l = 0; l < at.size(); ++l) {
                    const Decision here = scratch.visibility.decision[l],
                                   there = stages.visibility.decision[l];
                    ASSERT_EQ(here == Decision::undecided, there == Decision::undecided)
                        << "location " << l << ", trial " << trial;
                    ASSERT_EQ(bool(colors.valid[l]), bool(stages.colors.valid[l]))
                        << "location " << l;
                    for (size_t k = 0; k < 4; ++k)
                        ASSERT_NEAR(colors.rgba[4 * l + k], stages.colors.rgba[4 * l + k], 1e-5)
                            << "location " << l;
                    undecided += here == Decision::undecided;
                    covered += here == Decision::covered;
                    ++all;
                }
            }
    }
    // All ways of deciding were taken.
    if (kind == Kind_of::still_pinhole) {
        EXPECT_EQ(covered, 0u);
    } else {
        EXPECT_GT(undecided, all / 200);
        EXPECT_GT(covered, all / 200);
    }
}

INSTANTIATE_TEST_SUITE_P(All, SeeVisible,
                         testing::Combine(testing::ValuesIn(instruction_sets()),
                                          testing::Values(Kind_of::still_pinhole,
                                                          Kind_of::defocused, Kind_of::moving,
                                                          Kind_of::moving_in_depth),
                                          testing::Values(1, 4, 20)));

TEST(SeeVisible, WherePicturesAreMadeNothingChanges) {
    TestFolder folder;
    const std::string file = folder / "samples.npz";
    PlainContext ctx;
    write_npz(random_samples(40, 30, 3, Kind_of::moving_in_depth), file, {}, ctx);
    for (const char* locations : {R"("per-pixel": 8)", R"("per-pixel": 6, "sets": 3)",
                                  R"("per-pixel": 8, "per-slice": 4)"}) {
        const GraphRun fused(tlfr_text(file, locations)),
            apart(tlfr_text(file, locations), 32, 1, false);
        ASSERT_EQ(fused.picture.width(), 40);
        const std::vector<float> a = values_of(fused.picture), b = values_of(apart.picture);
        for (size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5) << locations;
    }
}

TEST(SeeVisible, GivesTheSameBitsForAnyTilesAndThreads) {
    TestFolder folder;
    const std::string file = folder / "samples.npz";
    PlainContext ctx;
    write_npz(random_samples(50, 30, 2, Kind_of::moving), file, {}, ctx);
    const GraphRun first(tlfr_text(file, R"("per-pixel": 8)"), 32, 1);
    for (const auto& [tile, threads] : {std::pair(7, 2), std::pair(16, 7), std::pair(64, 1)}) {
        const GraphRun other(tlfr_text(file, R"("per-pixel": 8)"), tile, threads);
        EXPECT_EQ(values_of(first.picture), values_of(other.picture)) << "tile " << tile;
    }
}

}  // namespace
}  // namespace weft
