#include "rpf/mutual_information.h"

#include <algorithm>
#include <cmath>

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
        const std::int64_t q = last < std::int64_t(most_bins) ? std::int64_t(b) : (std::int64_t(b) * last + 8) / 9;
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
        if (edge > scratch[0] && (e.bins == 1 || edge > e.edge[e.bins - 2])) e.edge[e.bins++ - 1] = edge;
    }
    return e;
}

size_t occupied_of(const BinMasks& x) {
    return size_t(std::count_if(x.count.begin(), x.count.begin() + std::ptrdiff_t(x.bins), [](std::uint32_t n) { return n > 0; }));
}

}  // namespace

Edges find_edges(const float* row, size_t n, float low, float high, Binning binning, size_t bins, std::vector<float>& scratch) {
    if (!(low < high)) return {};
    if (binning == Binning::centered) return centered_edges(bins);
    return binning == Binning::spanned ? spanned_edges(low, high) : rank_edges(row, n, bins, scratch);
}

std::int64_t MutualInformation::n_log_n(size_t n) {
    while (table_.size() <= n) {
        const auto k = double(table_.size());
        table_.push_back(k > 1 ? std::llround(k * std::log(k) * 0x1p32) : 0);
    }
    return table_[n];
}

double MutualInformation::raw(const BinMasks& x, const BinMasks& y, size_t& occupied) {
    std::uint32_t cells[most_bins * most_bins];
    WEFT_PICK(count_pairs)(x, y, cells);
    n_log_n(x.samples);
    const std::int64_t* table = table_.data();
    std::int64_t sum = table[x.samples];
    occupied = 0;
    for (size_t i = 0; i < x.bins * y.bins; ++i) {
        sum += table[cells[i]];
        occupied += cells[i] > 0;
    }
    for (size_t i = 0; i < x.bins; ++i) sum -= table[x.count[i]];
    for (size_t j = 0; j < y.bins; ++j) sum -= table[y.count[j]];
    return double(sum) * 0x1p-32 / double(x.samples);
}

double MutualInformation::operator()(const BinMasks& x, const BinMasks& y) {
    if (x.samples == 0) return 0;
    const auto kx = double(occupied_of(x)), ky = double(occupied_of(y)), twice = 2 * double(x.samples);
    if (kx < 2 || ky < 2) return 0;
    size_t occupied = 0, ignored = 0;
    double found = raw(x, y, occupied);
    switch (correction_) {
        case Correction::none: break;
        case Correction::miller_madow: found -= (double(occupied) - kx - ky + 1) / twice; break;
        case Correction::asymptotic: found -= (kx - 1) * (ky - 1) / twice; break;
        case Correction::shuffle: {
            // Samples lie in rows of the picture, so a shift by whole words keeps what is common to neighbours apart.
            constexpr size_t shuffles = 4;
            double chance = 0;
            shifted_ = y;
            for (size_t k = 1; k <= shuffles; ++k) {
                for (size_t b = 0; b < y.bins; ++b)
                    for (size_t i = 0; i < y.samples; ++i) {
                        const size_t from = (i + k * y.samples / (shuffles + 1)) % y.samples;
                        const std::uint64_t bit = y.bits[b * y.words + from / 64] >> (from % 64) & 1;
                        std::uint64_t& word = shifted_.bits[b * y.words + i / 64];
                        word = (word & ~(std::uint64_t(1) << (i % 64))) | bit << (i % 64);
                    }
                chance += raw(x, shifted_, ignored) / double(shuffles);
            }
            found -= chance;
        }
    }
    return std::max(found, 0.0);
}

}  // namespace weft::rpf
