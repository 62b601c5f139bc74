// Bins as bits, and the bits that two bins share.
#include <algorithm>

#include "rpf/kernels.h"
#include "rpf/simd.h"

namespace weft::rpf::WEFT_ISA {
namespace {

// Bit i: row[i] >= edge.
void at_least(const float* row, size_t n, float edge, std::uint64_t* bits) {
    const VF low = hn::Set(f, edge);
    for (size_t word = 0; word * 64 < n; ++word) {
        std::uint64_t all = 0;
        const size_t end = std::min<size_t>(64, (n - word * 64 + lanes - 1) / lanes * lanes);
        for (size_t i = 0; i < end; i += lanes) {
            std::uint8_t bytes[8] = {};
            hn::StoreMaskBits(f, hn::Ge(hn::LoadU(f, row + word * 64 + i), low), bytes);
            all |= std::uint64_t(bytes[0] | (lanes > 8 ? bytes[1] << 8 : 0)) << i;
        }
        if (n - word * 64 < 64) all &= (std::uint64_t(1) << (n - word * 64)) - 1;
        bits[word] = all;
    }
}

std::uint32_t common(const std::uint64_t* a, const std::uint64_t* b, size_t words) {
    std::uint32_t n = 0;
    for (size_t w = 0; w < words; ++w) n += std::uint32_t(__builtin_popcountll(a[w] & b[w]));
    return n;
}

}  // namespace

void sort_into_bins(const float* row, size_t n, const Edges& edges, BinMasks& masks) {
    masks.bins = edges.bins;
    masks.words = (n + 63) / 64;
    masks.samples = n;
    masks.bits.resize(most_bins * masks.words);
    const size_t words = masks.words;
    std::uint64_t* bits = masks.bits.data();
    // Of all, those past each edge in turn; what is past one and not past the next is the bin between.
    std::fill_n(bits, words, ~std::uint64_t(0));
    if (n % 64) bits[words - 1] = (std::uint64_t(1) << (n % 64)) - 1;
    for (size_t b = 1; b < edges.bins; ++b) {
        std::uint64_t *past = bits + b * words, *before = past - words;
        at_least(row, n, edges.edge[b - 1], past);
        for (size_t w = 0; w < words; ++w) before[w] &= ~past[w];
    }
    for (size_t b = 0; b < edges.bins; ++b) masks.count[b] = common(bits + b * words, bits + b * words, words);
}

// The last of each column and row is what the others leave.
void count_pairs(const BinMasks& a, const BinMasks& b, std::uint32_t* cells) {
    const size_t words = a.words, last_a = a.bins - 1, last_b = b.bins - 1;
    std::array<std::uint32_t, most_bins> left = b.count;
    for (size_t i = 0; i < last_a; ++i) {
        std::uint32_t rest = a.count[i];
        for (size_t j = 0; j < last_b; ++j) {
            const std::uint32_t n = a.count[i] == 0 || b.count[j] == 0 ? 0 : common(&a.bits[i * words], &b.bits[j * words], words);
            cells[i * b.bins + j] = n;
            rest -= n;
            left[j] -= n;
        }
        cells[i * b.bins + last_b] = rest;
        left[last_b] -= rest;
    }
    for (size_t j = 0; j <= last_b; ++j) cells[last_a * b.bins + j] = left[j];
}

}  // namespace weft::rpf::WEFT_ISA
