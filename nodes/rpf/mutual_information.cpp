#include "rpf/mutual_information.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rpf/kernels.h"

namespace weft::rpf {
namespace {

Edges centered_edges(size_t bins) {
    Edges e{{}, bins};
    for (size_t b = 1; b < bins; ++b) e.edge[b - 1] = float(b) - 0.5f * float(bins);
    return e;
}

// Bins are where numbers round to; q of more than ten becomes floor(9 q / last).
Edges spanned_edges(float low, float high) {
    const float first = std::round(low);
    const auto last = std::int64_t(std::min(std::round(high) - first, 1e6f));
    Edges e{{}, size_t(std::min<std::int64_t>(last + 1, most_bins))};
    for (size_t b = 1; b < e.bins; ++b) {
        const std::int64_t q =
            last < std::int64_t(most_bins) ? std::int64_t(b) : (std::int64_t(b) * last + 8) / 9;
        e.edge[b - 1] = first + float(q) - 0.5f;
    }
    return e;
}

Edges rank_edges(const float* row, size_t n, size_t bins, std::vector<float>& scratch) {
    scratch.assign(row, row + n);
    std::sort(scratch.begin(), scratch.end());
    Edges e;
    for (size_t b = 1; b < bins; ++b) {
        const float edge = scratch[b * n / bins];
        if (edge > scratch[0] && (e.bins == 1 || edge > e.edge[e.bins - 2]))
            e.edge[e.bins++ - 1] = edge;
    }
    return e;
}

// Samples lie in rows of the picture, so a shift keeps what is common to neighbours apart.
void shift(const BinnedRows& from, size_t by, BinnedRows& to) {
    to = from;
    for (size_t row = 0; row < from.rows.size(); ++row)
        for (size_t c = from.rows[row].first; c < from.end(row); ++c)
            for (size_t i = 0; i < from.samples; ++i) {
                const size_t j = (i + by) % from.samples;
                const std::uint64_t bit = from.bits[j / 64 * from.pitch + c] >> (j % 64) & 1;
                std::uint64_t& word = to.bits[i / 64 * to.pitch + c];
                word = (word & ~(std::uint64_t(1) << (i % 64))) | bit << (i % 64);
            }
}

Edges find_edges(const NumberRow& row, size_t n, Binning binning, size_t bins,
                 std::vector<float>& scratch) {
    if (!(row.low < row.high)) return {};
    if (binning == Binning::rank) return rank_edges(row.numbers, n, bins, scratch);
    Edges e =
        binning == Binning::centered ? centered_edges(bins) : spanned_edges(row.low, row.high);
    for (size_t b = 1; b < e.bins; ++b) e.edge[b - 1] = row.mean + e.edge[b - 1] / row.scale;
    return e;
}

}  // namespace

void sort_rows(std::span<const NumberRow> rows, size_t n, Binning binning, size_t bins,
               BinnedRows& sorted) {
    sorted.rows.resize(rows.size());
    size_t columns = 0;
    for (size_t i = 0; i < rows.size(); ++i) {
        BinnedRows::Row& row = sorted.rows[i];
        row.edges = find_edges(rows[i], n, binning, bins, sorted.scratch);
        row.first = columns;
        columns += row.bins() - 1;
    }
    sorted.samples = n;
    sorted.words = (n + 63) / 64;
    sorted.pitch = columns;
    sorted.bits.resize(sorted.words * sorted.pitch + BinnedRows::padding);
    for (size_t i = 0; i < rows.size(); ++i) WEFT_PICK(sort_into_bins)
    (rows[i].numbers, n, sorted.rows[i].edges, &sorted.bits[sorted.rows[i].first], sorted.pitch);
    sorted.counts.resize(columns + BinnedRows::padding);
    WEFT_PICK(count_each)
    (sorted.bits.data(), columns, sorted.pitch, sorted.words, sorted.counts.data());
    for (BinnedRows::Row& row : sorted.rows) {
        const std::uint32_t* counts = &sorted.counts[row.first];
        const size_t last = row.bins() - 1;
        row.count[last] = std::uint32_t(n);
        for (size_t b = 0; b < last; ++b) {
            row.count[b] = counts[b];
            row.count[last] -= counts[b];
        }
    }
}

void MutualInformation::grow_table(size_t n) {
    while (table_.size() <= n) {
        const auto k = double(table_.size());
        table_.push_back(k > 1 ? std::llround(k * std::log(k) * 0x1p32) : 0);
    }
}

MutualInformation::Margin MutualInformation::margin_of(const BinnedRows::Row& row) const {
    Margin margin{0, 0};
    for (size_t b = 0; b < row.bins(); ++b) {
        margin.n_log_n += table_[row.count[b]];
        margin.occupied += row.count[b] > 0;
    }
    return margin;
}

void MutualInformation::count(const BinnedRows& x, Range of_x, const BinnedRows& y, Range of_y) {
    const size_t first_x = x.rows[of_x.begin].first, first_y = y.rows[of_y.begin].first;
    const size_t rows = x.end(of_x.end - 1) - first_x, columns = y.end(of_y.end - 1) - first_y;
    pitch_ = (columns + BinnedRows::padding - 1) / BinnedRows::padding * BinnedRows::padding;
    counts_.resize(rows * pitch_);
    WEFT_PICK(count_common)
    (x.column(first_x), rows, y.column(first_y), columns, x.pitch, x.words, counts_.data(), pitch_);
}

namespace {

// The sum over cells of two rows, one of which has `last_y` bins and one more, and how many are not
// empty, if that is `asked`. Cells of the last bins are what the others leave.
struct Cells {
    std::int64_t n_log_n = 0;
    size_t occupied = 0;
};
template <bool asked, size_t last_y>
Cells sum_cells(const std::int64_t* table, const BinnedRows::Row& x, const BinnedRows::Row& y,
                const std::uint32_t* counts, size_t pitch) {
    Cells all;
    const auto add = [&](std::uint32_t n) {
        all.n_log_n += table[n];
        if (asked) all.occupied += n > 0;
    };
    std::array<std::uint32_t, last_y + 1> left;
    std::copy_n(y.count.begin(), last_y + 1, left.begin());
    const size_t last_x = x.bins() - 1;
    for (size_t i = 0; i < last_x; ++i, counts += pitch) {
        std::uint32_t rest = x.count[i];
#pragma GCC unroll 9
        for (size_t j = 0; j < last_y; ++j) {
            const std::uint32_t n = counts[j];
            add(n);
            rest -= n;
            left[j] -= n;
        }
        add(rest);
        left[last_y] -= rest;
    }
    for (const std::uint32_t n : left) add(n);
    return all;
}

// By the number of bins but one.
template <bool asked>
constexpr auto sums_of_cells = []<size_t... last>(std::index_sequence<last...>) {
    return std::array{&sum_cells<asked, last>...};
}
(std::make_index_sequence<most_bins>());

}  // namespace

void MutualInformation::operator()(const BinnedRows& rows, Range x, Range y,
                                   std::vector<double>& information) {
    information.assign(x.size() * y.size(), 0.0);
    if (information.empty() || rows.samples == 0) return;
    grow_table(rows.samples);
    margins_.resize(rows.rows.size());
    for (const Range& range : {x, y})
        for (size_t i = range.begin; i < range.end; ++i) margins_[i] = margin_of(rows.rows[i]);

    const auto samples = double(rows.samples);
    const auto& sums =
        correction_ == Correction::miller_madow ? sums_of_cells<true> : sums_of_cells<false>;
    const auto add_all = [&](double part) {
        for (size_t i = x.begin; i < x.end; ++i)
            for (size_t j = y.begin; j < y.end; ++j) {
                const Margin &mx = margins_[i], &my = margins_[j];
                if (mx.occupied < 2 || my.occupied < 2) continue;
                const std::uint32_t* counts =
                    &counts_[(rows.rows[i].first - rows.rows[x.begin].first) * pitch_ +
                             rows.rows[j].first - rows.rows[y.begin].first];
                const Cells cells = sums[rows.rows[j].bins() - 1](table_.data(), rows.rows[i],
                                                                  rows.rows[j], counts, pitch_);
                const std::int64_t sum =
                    table_[rows.samples] + cells.n_log_n - mx.n_log_n - my.n_log_n;
                const double found = double(sum) * 0x1p-32 / samples;
                double bias = 0;
                if (correction_ == Correction::miller_madow)
                    bias = (double(cells.occupied) - double(mx.occupied + my.occupied) + 1) /
                           (2 * samples);
                if (correction_ == Correction::asymptotic)
                    bias = double(mx.occupied - 1) * double(my.occupied - 1) / (2 * samples);
                information[(i - x.begin) * y.size() + j - y.begin] += part * (found - bias);
            }
    };
    count(rows, x, rows, y);
    add_all(1);
    if (correction_ == Correction::shuffle) {
        constexpr size_t shuffles = 4;
        for (size_t k = 1; k <= shuffles; ++k) {
            shift(rows, k * rows.samples / (shuffles + 1), shifted_);
            count(rows, x, shifted_, y);
            add_all(-1.0 / double(shuffles));
        }
    }
    for (double& i : information) i = std::max(i, 0.0);
}

}  // namespace weft::rpf
