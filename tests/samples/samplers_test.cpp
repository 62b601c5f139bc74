// Samplers: what each promises of its points.
#include "samples/samplers.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "samples/random.h"

namespace weft {
namespace {

constexpr Sampler all_samplers[] = {Sampler::independent, Sampler::stratified, Sampler::sobol};

std::vector<std::vector<float>> points(Sampler sampler, std::uint64_t seed, int x, int y, int spp,
                                       int dimensions = 5) {
    std::vector<float> flat(size_t(dimensions) * size_t(spp));
    fill_samples(sampler, seed, x, y, spp, 0, spp, dimensions, flat.data(), size_t(spp));
    std::vector<std::vector<float>> out;
    for (int d = 0; d < dimensions; ++d)
        out.emplace_back(flat.begin() + d * spp, flat.begin() + (d + 1) * spp);
    return out;
}

// Whether each of n equal intervals holds one of the n numbers.
bool stratified(const std::vector<float>& numbers) {
    std::set<int> cells;
    for (float v : numbers) cells.insert(int(double(v) * double(numbers.size())));
    return cells.size() == numbers.size();
}
bool in_grid(const std::vector<float>& a, const std::vector<float>& b, int columns, int rows) {
    std::set<int> cells;
    for (size_t i = 0; i < a.size(); ++i)
        cells.insert(int(a[i] * float(columns)) * rows + int(b[i] * float(rows)));
    return cells.size() == a.size();
}

TEST(Samplers, numbers_lie_in_the_unit_interval) {
    for (Sampler sampler : all_samplers)
        for (int spp : {1, 2, 3, 7, 16, 1000})
            for (const auto& dimension : points(sampler, 5, 12, 34, spp, sampler_dimensions))
                for (float v : dimension) {
                    EXPECT_GE(v, 0);
                    EXPECT_LT(v, 1);
                }
}

TEST(Samplers, a_number_depends_on_seed_pixel_index_and_dimension_only) {
    for (Sampler sampler : all_samplers) {
        const auto whole = points(sampler, 9, 3, 4, 24, 6);
        for (int i = 0; i < 24; ++i) {
            float one[6];
            fill_samples(sampler, 9, 3, 4, 24, i, 1, 6, one, 1);
            for (size_t d = 0; d < 6; ++d) EXPECT_EQ(one[d], whole[d][size_t(i)]);
        }
        EXPECT_EQ(points(sampler, 9, 3, 4, 24, 3)[2], whole[2]);
        EXPECT_NE(points(sampler, 10, 3, 4, 24, 6), whole);
        EXPECT_NE(points(sampler, 9, 4, 4, 24, 6), whole);
        EXPECT_NE(whole[0], whole[1]);
    }
}

TEST(Samplers, means_are_one_half_without_bias_over_pixels) {
    for (Sampler sampler : all_samplers)
        for (int spp : {1, 3, 4}) {
            std::array<double, 5> mean{}, square{}, product{};
            constexpr int side = 64;
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    const auto p = points(sampler, 1, x, y, spp);
                    for (size_t d = 0; d < 5; ++d)
                        for (size_t i = 0; i < size_t(spp); ++i) {
                            mean[d] += double(p[d][i]), square[d] += double(p[d][i] * p[d][i]);
                            product[d] += double(p[d][i] * p[(d + 1) % 5][i]);
                        }
                }
            const double n = side * side * spp, error = 4 * 0.29 / std::sqrt(n);
            for (size_t d = 0; d < 5; ++d) {
                EXPECT_NEAR(mean[d] / n, 0.5, error);
                EXPECT_NEAR(square[d] / n, 1.0 / 3, error);
                EXPECT_NEAR(product[d] / n, 0.25, error);  // dimensions do not go together
            }
        }
}

TEST(Samplers, stratified_fills_each_cell_of_a_grid_and_each_coordinate_alone) {
    const struct {
        int spp, columns, rows;
    } grids[] = {{4, 2, 2}, {8, 4, 2}, {9, 3, 3}, {16, 4, 4}, {12, 4, 3}, {64, 8, 8}};
    for (const auto& g : grids)
        for (int x = 0; x < 5; ++x) {
            const auto p = points(Sampler::stratified, 7, x, 1, g.spp, 4);
            for (size_t d = 0; d < 4; d += 2) {
                EXPECT_TRUE(in_grid(p[d], p[d + 1], g.columns, g.rows)) << g.spp;
                EXPECT_TRUE(stratified(p[d])) << g.spp;
                EXPECT_TRUE(stratified(p[d + 1])) << g.spp;
            }
        }
}

TEST(Samplers, stratified_shuffles_pairs_against_each_other) {
    const auto p = points(Sampler::stratified, 7, 0, 0, 256, 4);
    double product = 0;
    for (size_t i = 0; i < 256; ++i) product += double((p[0][i] - 0.5f) * (p[2][i] - 0.5f));
    EXPECT_LT(std::fabs(product / 256 * 12), 0.25);
}

TEST(Samplers, sobol_stratifies_each_coordinate_and_the_first_pair_in_all_elementary_intervals) {
    for (int x = 0; x < 4; ++x) {
        const auto p = points(Sampler::sobol, 3, x, 2, 64, sampler_dimensions);
        for (const auto& dimension : p) EXPECT_TRUE(stratified(dimension));
        for (int columns = 1; columns <= 64; columns *= 2)
            EXPECT_TRUE(in_grid(p[0], p[1], columns, 64 / columns));
    }
}

TEST(Samplers, sobol_stratifies_blocks_of_pixels_too) {
    for (int block : {2, 4, 8})
        for (int spp : {1, 4}) {
            std::vector<std::vector<float>> all(5);
            for (int y = 0; y < block; ++y)
                for (int x = 0; x < block; ++x) {
                    const auto p = points(Sampler::sobol, 11, 16 + x, 24 + y, spp);
                    for (size_t d = 0; d < 5; ++d)
                        all[d].insert(all[d].end(), p[d].begin(), p[d].end());
                }
            for (const auto& dimension : all)
                EXPECT_TRUE(stratified(dimension)) << block << " " << spp;
        }
}

TEST(Samplers, the_owen_scramble_keeps_elementary_intervals_together) {
    // Numbers that share their upper bits share them after.
    for (std::uint32_t key : {1u, 77u, 0xdeadbeefu})
        for (int bits = 1; bits < 12; ++bits) {
            std::set<std::uint32_t> images;
            for (std::uint32_t i = 0; i < 1u << bits; ++i) {
                const std::uint32_t a = owen_scramble(i << (32 - bits), key),
                                    b = owen_scramble(i << (32 - bits) | 0x12345u >> bits, key);
                EXPECT_EQ(a >> (32 - bits), b >> (32 - bits));
                images.insert(a >> (32 - bits));
            }
            EXPECT_EQ(images.size(), size_t(1) << bits);
        }
}

TEST(Samplers, shuffled_is_one_to_one) {
    for (std::uint32_t n : {1u, 2u, 3u, 5u, 8u, 31u, 100u})
        for (std::uint64_t key = 0; key < 20; ++key) {
            std::set<std::uint32_t> images;
            for (std::uint32_t i = 0; i < n; ++i) images.insert(shuffled(i, n, mix(key)));
            EXPECT_EQ(images.size(), n);
            EXPECT_LT(*images.rbegin(), n);
        }
}

TEST(Samplers, the_disk_map_leads_back) {
    for (int i = 0; i <= 40; ++i)
        for (int j = 0; j <= 40; ++j) {
            const float a = float(i) / 40, b = float(j) / 40;
            const Disk at = concentric_disk(a, b), back = concentric_square(at.u, at.v);
            EXPECT_NEAR(back.u, a, 2e-5f) << a << ' ' << b;
            EXPECT_NEAR(back.v, b, 2e-5f) << a << ' ' << b;
        }
    EXPECT_EQ(concentric_square(3, 0).u, 1);
}

TEST(Samplers, the_disk_map_keeps_areas) {
    constexpr int n = 400;
    std::array<int, 4> quadrant{};
    int inner = 0;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const Disk p = concentric_disk((float(i) + 0.5f) / n, (float(j) + 0.5f) / n);
            const float r2 = p.u * p.u + p.v * p.v;
            EXPECT_LE(r2, 1.00001f);
            inner += r2 < 0.25f;
            ++quadrant[size_t(p.u > 0) * 2 + size_t(p.v > 0)];
        }
    EXPECT_NEAR(inner, n * n / 4, n * 4);
    for (int count : quadrant) EXPECT_NEAR(count, n * n / 4, n);
    const Disk edge = concentric_disk(1, 0.75f);  // at an angle of pi/8
    EXPECT_NEAR(edge.u, std::cos(0.392699f), 1e-6);
    EXPECT_NEAR(edge.v, std::sin(0.392699f), 1e-6);
}

TEST(Samplers, pairs_of_any_number_keep_the_samplers_promise) {
    for (const Sampler sampler : all_samplers) {
        const SampleSequence sequence = sample_sequence(sampler, 5, 13, 7, 16);
        const auto flat = points(sampler, 5, 13, 7, 16, 10);
        for (const std::uint32_t pair : {0u, 1u, 4u, 5u, 6u, 20u, 1000u}) {
            std::vector<float> a, b;
            for (std::uint32_t i = 0; i < 16; ++i) {
                const Disk d = sequence(i, pair);
                a.push_back(d.u), b.push_back(d.v);
                if (pair >= 5) continue;
                EXPECT_EQ(d.u, flat[2 * pair][i]);
                EXPECT_EQ(d.v, flat[2 * pair + 1][i]);
            }
            if (sampler == Sampler::independent) continue;
            EXPECT_TRUE(stratified(a)) << int(sampler) << " pair " << pair;
            EXPECT_TRUE(stratified(b)) << int(sampler) << " pair " << pair;
            EXPECT_TRUE((pair > 0 && pair < 5) || in_grid(a, b, 4, 4))
                << int(sampler) << " pair " << pair;
        }
    }
}

// At one sample a pixel the pixels of an aligned 4 x 4 block share the work, in padded pairs too.
TEST(Samplers, neighbouring_pixels_share_one_sequence_in_every_pair) {
    for (const std::uint32_t pair : {0u, 7u, 31u}) {
        std::vector<float> a, b;
        for (int y = 8; y < 12; ++y)
            for (int x = 20; x < 24; ++x) {
                const Disk d = sample_sequence(Sampler::sobol, 3, x, y, 1)(0, pair);
                a.push_back(d.u), b.push_back(d.v);
            }
        EXPECT_TRUE(stratified(a) && stratified(b)) << pair;
        EXPECT_TRUE(in_grid(a, b, 4, 4)) << pair;
    }
}

TEST(Samplers, padded_pairs_are_independent_of_each_other) {
    double product = 0;
    constexpr int side = 64;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const SampleSequence s = sample_sequence(Sampler::sobol, 3, x, y, 1);
            product += (double(s(0, 6).u) - 0.5) * (double(s(0, 9).u) - 0.5);
        }
    EXPECT_NEAR(product / (side * side), 0, 4.0 / 12 / side);
}

}  // namespace
}  // namespace weft
