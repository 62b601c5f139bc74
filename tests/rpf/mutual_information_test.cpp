// Mutual information against exact values of the quantised distributions.
#include "rpf/mutual_information.h"

#include <numbers>

#include "tests/rpf/rpf_test.h"

namespace weft::rpf {
namespace {

// Rows are as long as whole vectors read.
std::vector<float> padded(std::vector<float> row) {
    row.resize((row.size() + 15) / 16 * 16, 0.0f);
    return row;
}
BinnedRows bins_of(const std::vector<std::vector<float>>& rows, size_t n,
                   Binning binning = Binning::centered, size_t bins = 5) {
    std::vector<NumberRow> of;
    for (const std::vector<float>& row : rows) {
        const auto [low, high] = std::minmax_element(row.begin(), row.begin() + std::ptrdiff_t(n));
        of.push_back({row.data(), *low, *high});
    }
    BinnedRows sorted;
    sort_rows(of, n, binning, bins, sorted);
    return sorted;
}
double information(const std::vector<float>& a, const std::vector<float>& b, size_t n,
                   Correction correction, Binning binning = Binning::centered) {
    MutualInformation between(correction);
    std::vector<double> i;
    between(bins_of({padded(a), padded(b)}, n, binning), {0, 1}, {1, 2}, i);
    return i.at(0);
}

// Pairs of a bivariate normal distribution of correlation rho (Box and Muller).
void draw_normal(double rho, size_t n, std::uint64_t seed, std::vector<float>& a,
                 std::vector<float>& b) {
    a.clear();
    b.clear();
    for (size_t i = 0; i < n; ++i) {
        const double r = std::sqrt(-2 * std::log(1 - double(chance(seed, 2 * i)))),
                     angle = 2 * std::numbers::pi * double(chance(seed, 2 * i + 1));
        const double x = r * std::cos(angle), y = r * std::sin(angle);
        a.push_back(float(x));
        b.push_back(float(rho * x + std::sqrt(1 - rho * rho) * y));
    }
}

// Of the five bins: cell masses of the bivariate normal, by the midpoint rule along x of exact
// masses along y.
double exact_information(double rho) {
    const auto below = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
    const double edge[6] = {-12, -1.5, -0.5, 0.5, 1.5, 12};
    double cell[5][5] = {}, row[5] = {}, column[5] = {};
    constexpr int steps = 4000;
    for (int i = 0; i < 5; ++i)
        for (int s = 0; s < steps; ++s) {
            const double width = (edge[i + 1] - edge[i]) / steps, x = edge[i] + (s + 0.5) * width;
            const double density = std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi) * width;
            const double scale = std::sqrt(1 - rho * rho);
            for (int j = 0; j < 5; ++j)
                cell[i][j] += density * (below((edge[j + 1] - rho * x) / scale) -
                                         below((edge[j] - rho * x) / scale));
        }
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j) row[i] += cell[i][j], column[j] += cell[i][j];
    double sum = 0;
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            if (cell[i][j] > 0) sum += cell[i][j] * std::log(cell[i][j] / row[i] / column[j]);
    return sum;
}

class OfNormals : public testing::TestWithParam<std::tuple<double, size_t>> {};

TEST_P(OfNormals, is_exact_but_for_the_bias_that_the_correction_takes_off) {
    const auto [rho, n] = GetParam();
    constexpr int trials = 200;
    double sum[3] = {}, squares = 0;
    std::vector<float> a, b;
    for (int trial = 0; trial < trials; ++trial) {
        draw_normal(rho, n, 77 + std::uint64_t(trial), a, b);
        const Correction corrections[3] = {Correction::none, Correction::miller_madow,
                                           Correction::asymptotic};
        for (int k = 0; k < 3; ++k) sum[k] += information(a, b, n, corrections[k]) / trials;
        squares += std::pow(information(a, b, n, Correction::none), 2) / trials;
    }
    const double exact = exact_information(rho),
                 deviation = std::sqrt(std::max(0.0, squares - sum[0] * sum[0])),
                 bias = 16.0 / (2 * double(n));
    const double margin = 4 * deviation / std::sqrt(double(trials));
    // Uncorrected: more than the truth, by about the bias. At 50 samples for 25 cells the expansion
    // is not yet good.
    const double loose = n < 100 ? 0.4 : 0.25;
    EXPECT_NEAR(sum[0], exact + bias, loose * bias + margin);
    // Corrected estimates are held at 0, which lifts their mean where the truth is 0.
    const double floor = rho == 0 ? 0.4 * deviation : 0;
    EXPECT_NEAR(sum[2], exact, loose * bias + margin + floor);
    EXPECT_NEAR(sum[1], exact, 0.6 * bias + margin + floor);
    // Where one row nearly gives the other most cells stay empty, and counting them all takes off
    // too much.
    EXPECT_TRUE(rho > 0.8 || std::abs(sum[2] - exact) < std::abs(sum[0] - exact));
}

INSTANTIATE_TEST_SUITE_P(All, OfNormals,
                         testing::Combine(testing::Values(0.0, 0.3, 0.5, 0.9),
                                          testing::Values(size_t(50), size_t(200), size_t(500),
                                                          size_t(2000))));

// Of x normal and y = x^2, both with mean 0 and deviation 1: cells are intervals of |x|.
double exact_information_of_squares() {
    const auto below = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
    std::vector<double> ends{0, 0.5, 1.5, 12};
    for (const double y : {-0.5, 0.5, 1.5}) ends.push_back(std::sqrt(1 + y * std::numbers::sqrt2));
    std::sort(ends.begin(), ends.end());
    double cell[5][5] = {}, row[5] = {}, column[5] = {};
    const auto bin = [](double v) { return std::clamp(int(std::floor(v + 2.5)), 0, 4); };
    for (size_t k = 0; k + 1 < ends.size(); ++k) {
        const double mass = below(ends[k + 1]) - below(ends[k]), x = (ends[k] + ends[k + 1]) / 2;
        const int y = bin((x * x - 1) / std::numbers::sqrt2);
        for (const int i : {bin(x), bin(-x)}) {
            cell[i][y] += mass;
            row[i] += mass;
            column[y] += mass;
        }
    }
    double sum = 0;
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            if (cell[i][j] > 0) sum += cell[i][j] * std::log(cell[i][j] / row[i] / column[j]);
    return sum;
}

class OfSquares : public testing::TestWithParam<size_t> {};

TEST_P(OfSquares, is_exact_but_for_the_bias_of_the_cells_that_there_are) {
    const size_t n = GetParam();
    constexpr int trials = 400;
    constexpr Correction corrections[3] = {Correction::none, Correction::miller_madow,
                                           Correction::asymptotic};
    double sum[3] = {}, squares[3] = {};
    std::vector<float> x, y;
    for (int trial = 0; trial < trials; ++trial) {
        draw_normal(0, n, 991 + std::uint64_t(trial), x, y);
        for (size_t i = 0; i < n; ++i) y[i] = (x[i] * x[i] - 1) / std::numbers::sqrt2_v<float>;
        for (int k = 0; k < 3; ++k) {
            const double found = information(x, y, n, corrections[k]);
            sum[k] += found / trials;
            squares[k] += found * found / trials;
        }
    }
    // 11 cells of 5 x 4 bins can be met: (11 - 5 - 4 + 1) / 2n; all but one of each are 12 / 2n.
    const double exact = exact_information_of_squares(), bias = 3 / (2 * double(n));
    for (int k = 0; k < 3; ++k) {
        const double deviation = std::sqrt(std::max(0.0, squares[k] - sum[k] * sum[k])),
                     margin =
                         4 * deviation / std::sqrt(double(trials)) + (n < 100 ? 1 : 0.5) * bias;
        const double expected = k == 0 ? bias : k == 1 ? 0 : bias - 12 / (2 * double(n));
        EXPECT_NEAR(sum[k] - exact, expected, margin) << k;
        // Scatter falls as the root of the number.
        EXPECT_NEAR(deviation * std::sqrt(double(n)), 0.85, 0.25) << k;
    }
}

INSTANTIATE_TEST_SUITE_P(All, OfSquares,
                         testing::Values(size_t(50), size_t(200), size_t(500), size_t(2000)));

TEST(MutualInformation, of_many_normals_is_the_published_value) {
    EXPECT_NEAR(exact_information(0.5), 0.1167, 2e-4);
    EXPECT_NEAR(exact_information(0.9), 0.5710, 5e-4);
}

TEST(MutualInformation, of_a_row_with_itself_is_its_entropy) {
    std::vector<float> row;
    for (int i = 0; i < 512; ++i) row.push_back(float(i % 4) - 1.5f);
    EXPECT_NEAR(information(row, row, row.size(), Correction::none, Binning::rank), std::log(4.0),
                1e-9);
    // Uniform, deviation 1: outer bins hold 0.067 each.
    std::vector<float> uniform;
    for (int i = 0; i < 4096; ++i)
        uniform.push_back(2 * std::numbers::sqrt3_v<float> * ((float(i) + 0.5f) / 4096 - 0.5f));
    EXPECT_NEAR(information(uniform, uniform, uniform.size(), Correction::none), 1.438, 2e-3);
}

TEST(MutualInformation, of_two_halves_is_the_logarithm_of_two) {
    std::vector<float> a(100, -1.0f), b(100, -1.0f);
    std::fill(a.begin() + 50, a.end(), 1.0f);
    std::fill(b.begin() + 50, b.end(), 1.0f);
    EXPECT_NEAR(information(a, b, 100, Correction::none), std::log(2.0), 1e-9);
}

TEST(MutualInformation, of_a_constant_is_zero) {
    const std::vector<float> constant(64, 0.0f);
    std::vector<float> row;
    for (int i = 0; i < 64; ++i) row.push_back(float(i % 3) - 1);
    for (Correction c :
         {Correction::none, Correction::miller_madow, Correction::asymptotic, Correction::shuffle})
        for (Binning b : {Binning::centered, Binning::spanned, Binning::rank})
            EXPECT_EQ(information(constant, row, 64, c, b), 0.0);
}

TEST(MutualInformation, depends_on_neither_order_nor_direction) {
    std::vector<float> a, b;
    draw_normal(0.6, 300, 5, a, b);
    for (Correction c : {Correction::none, Correction::miller_madow, Correction::asymptotic})
        EXPECT_EQ(information(a, b, 300, c), information(b, a, 300, c));
    std::vector<float> a2, b2;
    for (size_t i = 0; i < 300; ++i) {
        const size_t j = (i * 7 + 11) % 300;
        a2.push_back(a[j]);
        b2.push_back(b[j]);
    }
    EXPECT_EQ(information(a, b, 300, Correction::none), information(a2, b2, 300, Correction::none));
}

TEST(MutualInformation, of_independent_rows_is_nothing_to_the_shuffle) {
    std::vector<float> a, b;
    double sum = 0;
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        draw_normal(0, 400, seed, a, b);
        sum += information(a, b, 400, Correction::shuffle) / 50;
    }
    EXPECT_LT(sum, 0.008);  // held at 0, of a deviation of 0.008
}

TEST(Bins, of_the_range_are_one_deviation_wide_and_at_most_ten) {
    std::vector<float> row;
    for (int i = 0; i < 70; ++i) row.push_back(float(i % 7) - 3);
    EXPECT_EQ(bins_of({padded(row)}, 70, Binning::spanned).rows[0].bins(), 7u);
    row.push_back(200.0f);
    const BinnedRows::Row far = bins_of({padded(row)}, 71, Binning::spanned).rows[0];
    EXPECT_EQ(far.bins(), 10u);
    EXPECT_EQ(far.count[0], 70u);
    EXPECT_EQ(far.count[9], 1u);
}

TEST(Bins, are_counted_as_one_by_one_on_every_instruction_set) {
    for (const Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        for (const size_t n : {1u, 15u, 64u, 65u, 333u, 2500u}) {
            std::vector<std::vector<float>> rows(12);
            for (size_t k = 0; k < rows.size(); k += 2) {
                draw_normal(0.1 * double(k), n, 9 + k, rows[k], rows[k + 1]);
                rows[k] = padded(rows[k]);
                rows[k + 1] = padded(rows[k + 1]);
            }
            const BinnedRows sorted = bins_of(rows, n);
            const auto bin = [](float v) { return std::clamp(int(std::floor(v + 2.5f)), 0, 4); };
            // Columns of the last three rows with those of all.
            const size_t first = sorted.rows[9].first, columns = sorted.end(11),
                         mine = columns - first, pitch = (columns + 7) / 8 * 8;
            std::vector<std::uint32_t> counts(mine * pitch);
            WEFT_PICK(count_common)
            (sorted.column(first), mine, sorted.column(0), columns, sorted.pitch, sorted.words,
             counts.data(), pitch);
            for (size_t a = 9; a < 12; ++a)
                for (size_t b = 0; b < 12; ++b) {
                    std::uint32_t expected[25] = {};
                    for (size_t i = 0; i < n; ++i)
                        ++expected[bin(rows[a][i]) * 5 + bin(rows[b][i])];
                    for (size_t i = 0; i + 1 < sorted.rows[a].bins(); ++i)
                        for (size_t j = 0; j + 1 < sorted.rows[b].bins(); ++j)
                            EXPECT_EQ(counts[(sorted.rows[a].first + i - first) * pitch +
                                             sorted.rows[b].first + j],
                                      expected[i * 5 + j])
                                << n << " " << a << " " << b;
                }
        }
    }
}

}  // namespace
}  // namespace weft::rpf
