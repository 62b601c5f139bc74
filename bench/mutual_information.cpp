// How far is the mutual information of M samples from that of the distribution, and how much does
// it scatter? Bins as preset report has them: five, one deviation wide. The truth is that of the
// binned distribution, from 2^20 samples. Prints a Markdown table of bias and standard deviation,
// in nats, over 400 trials, a column a correction.
#include "rpf/mutual_information.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "samples/random.h"

using namespace weft;
using namespace weft::rpf;

namespace {

struct Moments {
    double mean, deviation;
};

using Row = std::vector<float>;

// Mean 0, deviation 1, padded to whole vectors.
void normalise(Row& row, size_t n) {
    double sum = 0, squares = 0;
    for (size_t i = 0; i < n; ++i) sum += double(row[i]);
    for (size_t i = 0; i < n; ++i) squares += std::pow(double(row[i]) - sum / double(n), 2);
    for (float& x : row)
        x = float((double(x) - sum / double(n)) / std::sqrt(squares / double(n - 1)));
    row.resize((n + 15) / 16 * 16, 0.0f);
}

struct Distribution {
    const char* name;
    double rho;
    bool functional;  // the second row is the first one's square
};

double information(const Distribution& of, size_t n, std::uint64_t seed,
                   MutualInformation& between) {
    Row a, b;
    for (size_t i = 0; i < n; ++i) {
        const std::uint64_t bits = mix(mix(seed) + i);
        const double r = std::sqrt(-2 * std::log(1 - double(unit_float(std::uint32_t(bits)))));
        const double angle = 2 * std::numbers::pi * double(unit_float(std::uint32_t(bits >> 32)));
        const double x = r * std::cos(angle), y = r * std::sin(angle);
        a.push_back(float(x));
        b.push_back(float(of.functional ? x * x : of.rho * x + std::sqrt(1 - of.rho * of.rho) * y));
    }
    std::vector<NumberRow> rows;
    for (Row* row : {&a, &b}) {
        normalise(*row, n);
        const auto [low, high] =
            std::minmax_element(row->begin(), row->begin() + std::ptrdiff_t(n));
        rows.push_back({row->data(), *low, *high});
    }
    BinnedRows sorted;
    sort_rows(rows, n, Binning::centered, 5, sorted);
    std::vector<double> found;
    between(sorted, {0, 1}, {1, 2}, found);
    return found[0];
}

Moments moments(const Distribution& of, size_t n, Correction correction) {
    constexpr int trials = 400;
    MutualInformation between(correction);
    double sum = 0, squares = 0;
    for (int trial = 0; trial < trials; ++trial) {
        const double i = information(of, n, std::uint64_t(trial) + 1, between);
        sum += i / trials;
        squares += i * i / trials;
    }
    return {sum, std::sqrt(std::max(0.0, squares - sum * sum))};
}

}  // namespace

int main() {
    fmt::print(
        "| distribution | exact | M | none | miller-madow | asymptotic | shuffle "
        "|\n|---|---:|---:|---:|---:|---:|---:|\n");
    for (const Distribution& of : {Distribution{"independent", 0, false},
                                   {"normal, rho 0.5", 0.5, false},
                                   {"normal, rho 0.9", 0.9, false},
                                   {"y = x^2", 0, true}}) {
        MutualInformation plain;
        const double exact = information(of, size_t(1) << 20, 77, plain);
        for (const size_t n : {50u, 100u, 200u, 500u, 1000u, 2000u}) {
            fmt::print("| {} | {:.4f} | {} |", of.name, exact, n);
            for (const Correction c : {Correction::none, Correction::miller_madow,
                                       Correction::asymptotic, Correction::shuffle}) {
                const Moments found = moments(of, n, c);
                fmt::print(" {:+.4f} ± {:.4f} |", found.mean - exact, found.deviation);
            }
            fmt::print("\n");
        }
    }
}
