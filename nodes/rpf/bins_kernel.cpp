// Bins as bits, and how many bits columns share.
#include <algorithm>
#include <cstring>

#include "rpf/kernels.h"
#include "rpf/simd.h"

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

namespace weft::rpf::WEFT_ISA {
namespace {

// 64 numbers, and which of them are at least as large as an edge, as bits.
class Word {
  public:
    HWY_INLINE explicit Word(const float* row) {
        for (size_t i = 0; i < vectors; ++i) x_[i] = hn::LoadU(f, row + i * lanes);
    }
    HWY_INLINE std::uint64_t at_least(float edge) const {
        const VF low = hn::Set(f, edge);
#if defined(__AVX512BW__)
        const auto of = [&](size_t i)
                            HWY_ATTR { return _mm512_cmp_ps_mask(x_[i].raw, low.raw, _CMP_GE_OQ); };
        return _mm512_kunpackd(_mm512_kunpackw(of(3), of(2)), _mm512_kunpackw(of(1), of(0)));
#else
        std::uint64_t all = 0;
        for (size_t i = 0; i < vectors; ++i) {
            std::uint8_t bytes[8] = {};
            std::uint16_t some;
            hn::StoreMaskBits(f, hn::Ge(x_[i], low), bytes);
            std::memcpy(&some, bytes, sizeof some);
            all |= std::uint64_t(some) << (i * lanes);
        }
        return all;
#endif
    }

  private:
    static constexpr size_t vectors = 64 / lanes;
    VF x_[vectors];
};

constexpr size_t together = 8;  // columns that are compared with others at once

using B = hn::ScalableTag<std::uint8_t>;
using W = hn::ScalableTag<std::uint64_t>;
constexpr size_t word_lanes = hn::MaxLanes(W());

// Of `together` columns with as many others as a vector holds words. Bits are counted in bytes,
// which hold those of 31 words.
HWY_INLINE void count_some(const std::uint64_t* const* a, const std::uint64_t* b, size_t pitch,
                           size_t words, std::uint32_t* const* to) {
    constexpr B bytes;
    constexpr W whole;
    hn::Vec<W> sum[together];
    for (auto& s : sum) s = hn::Zero(whole);
    for (size_t begin = 0; begin < words; begin += 31) {
        hn::Vec<B> bits[together];
        for (auto& v : bits) v = hn::Zero(bytes);
        for (size_t w = begin; w < std::min(words, begin + 31); ++w) {
            const auto other = hn::LoadU(whole, b + w * pitch);
            for (size_t o = 0; o < together; ++o)
                bits[o] =
                    hn::Add(bits[o], hn::PopulationCount(hn::BitCast(
                                         bytes, hn::And(hn::Set(whole, a[o][w * pitch]), other))));
        }
        for (size_t o = 0; o < together; ++o) sum[o] = hn::Add(sum[o], hn::SumsOf8(bits[o]));
    }
    for (size_t o = 0; o < together; ++o) {
        std::uint64_t found[word_lanes];
        hn::StoreU(sum[o], whole, found);
        for (size_t k = 0; k < word_lanes; ++k) to[o][k] = std::uint32_t(found[k]);
    }
}

#if defined(__AVX512F__)
// The same where the processor counts bits itself, which not every one of this level does.
__attribute__((target("avx512vpopcntdq"))) void count_some_natively(const std::uint64_t* const* a,
                                                                    const std::uint64_t* b,
                                                                    size_t pitch, size_t words,
                                                                    std::uint32_t* const* to) {
    __m512i sum[together];
    for (auto& s : sum) s = _mm512_setzero_si512();
    for (size_t w = 0; w < words; ++w) {
        const __m512i other = _mm512_loadu_si512(b + w * pitch);
        for (size_t o = 0; o < together; ++o)
            sum[o] = _mm512_add_epi64(
                sum[o], _mm512_popcnt_epi64(_mm512_and_si512(
                            _mm512_set1_epi64(static_cast<long long>(a[o][w * pitch])), other)));
    }
    for (size_t o = 0; o < together; ++o)
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(to[o]), _mm512_cvtepi64_epi32(sum[o]));
}
const bool counts_natively = __builtin_cpu_supports("avx512vpopcntdq");
#endif

}  // namespace

void sort_into_bins(const float* row, size_t n, const Edges& edges, std::uint64_t* columns,
                    size_t pitch) {
    const size_t last = edges.bins - 1;
    float rest[64] = {};
    // What is past one edge and not past the next lies in the bin between.
    for (size_t begin = 0; begin < n; begin += 64, columns += pitch) {
        const bool whole = n - begin >= 64;
        if (!whole) std::copy(row + begin, row + n, rest);
        const Word word(whole ? row + begin : rest);
        const std::uint64_t all = whole ? ~std::uint64_t(0) : (std::uint64_t(1) << (n - begin)) - 1;
        std::uint64_t past = all;
        for (size_t b = 0; b < last; ++b) {
            const std::uint64_t next = word.at_least(edges.edge[b]);
            columns[b] = past & ~next;
            past &= next;
        }
    }
}

void count_each(const std::uint64_t* bits, size_t columns, size_t pitch, size_t words,
                std::uint32_t* counts) {
    constexpr W whole;
    for (size_t j = 0; j < columns; j += word_lanes) {
        auto sum = hn::Zero(whole);
        for (size_t w = 0; w < words; ++w)
            sum = hn::Add(sum, hn::PopulationCount(hn::LoadU(whole, bits + w * pitch + j)));
        std::uint64_t found[word_lanes];
        hn::StoreU(sum, whole, found);
        for (size_t k = 0; k < word_lanes; ++k) counts[j + k] = std::uint32_t(found[k]);
    }
}

void count_common(const std::uint64_t* a, size_t rows, const std::uint64_t* b, size_t columns,
                  size_t pitch, size_t words, std::uint32_t* counts, size_t counts_pitch) {
    for (size_t i = 0; i < rows; i += together) {
        const std::uint64_t* mine[together];
        std::uint32_t* to[together];
        for (size_t j = 0; j < columns; j += word_lanes) {
            for (size_t o = 0; o < together; ++o) {  // the last again where there are fewer
                const size_t row = std::min(i + o, rows - 1);
                mine[o] = a + row;
                to[o] = counts + row * counts_pitch + j;
            }
#if defined(__AVX512F__)
            if (counts_natively) {
                count_some_natively(mine, b + j, pitch, words, to);
                continue;
            }
#endif
            count_some(mine, b + j, pitch, words, to);
        }
    }
}

}  // namespace weft::rpf::WEFT_ISA
