// Bins as bits, and how many bits columns share.
#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "rpf/kernels.h"
#include "rpf/simd.h"

#include <immintrin.h>

namespace weft::rpf::WEFT_ISA {
namespace {

#if HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_AVX2
// Which of as many numbers as a vector has bytes are at least something, a byte each.
class Piece {
  public:
    using B = hn::Repartition<std::uint8_t, F>;
    static constexpr size_t numbers = 4 * lanes;

    // Vectors of quarters that lie as far apart as narrowing two vectors to one brings them.
    HWY_INLINE explicit Piece(const float* row) {
        constexpr hn::FixedTag<float, 4> four{};
        for (size_t i = 0; i < 4; ++i)
#if HWY_TARGET == HWY_SSE4
            x_[i] = hn::LoadU(four, row + 4 * i);
#else
            x_[i] = hn::Combine(f, hn::LoadU(four, row + 4 * i + 16), hn::LoadU(four, row + 4 * i));
#endif
    }
    HWY_INLINE hn::Vec<B> at_least(VF edge) const {
        constexpr hn::Repartition<std::int16_t, F> narrow;
        const auto is = [&](size_t i) HWY_ATTR {
            return hn::BitCast(hn::RebindToSigned<F>(), hn::VecFromMask(f, hn::Ge(x_[i], edge)));
        };
        const auto low = hn::ReorderDemote2To(narrow, is(0), is(1)),
                   high = hn::ReorderDemote2To(narrow, is(2), is(3));
#if HWY_TARGET == HWY_SSE4
        return {_mm_packs_epi16(low.raw, high.raw)};
#else
        return {_mm256_packs_epi16(low.raw, high.raw)};
#endif
    }

  private:
    VF x_[4];
};

// Which of 64 numbers lie in each bin but the last. Narrowed to bytes, four vectors of answers are
// one, whose bits are brought together at once.
HWY_INLINE void sort_word(const float* row, const Edges& edges, std::uint64_t* columns) {
    constexpr Piece::B bytes;
    const size_t last = edges.bins - 1;
    for (size_t i = 0; i < 64; i += Piece::numbers) {
        const Piece piece(row + i);
        auto past = hn::Set(bytes, std::uint8_t(255));
        auto* to = reinterpret_cast<std::uint8_t*>(columns) + i / 8;
        for (size_t b = 0; b < last; ++b, to += sizeof *columns) {
            const auto next = piece.at_least(hn::Set(f, edges.edge[b]));
            hn::StoreMaskBits(bytes, hn::MaskFromVec(hn::AndNot(next, past)), to);
            past = next;
        }
    }
}
#else
// Of numbers those that are past all edges so far.
class Piece {
  public:
    HWY_INLINE explicit Piece(const float* row)
        : x_(hn::LoadU(f, row)), past_(hn::Eq(hn::Zero(f), hn::Zero(f))) {}
    // Which of these are below the next, as bits.
    HWY_INLINE void store_below(VF edge, char* to) {
        const auto next = hn::Ge(x_, edge);
        hn::StoreMaskBits(f, hn::AndNot(next, past_), reinterpret_cast<std::uint8_t*>(to));
        past_ = next;
    }

  private:
    VF x_;
    hn::Mask<F> past_;
};

// Which of 64 numbers lie in each bin but the last. Bits go to memory piece by piece: putting them
// together in registers takes longer than comparing. Two pieces share the edges, and lie half a
// word apart lest the compiler put them together. Unrolled, or masks go round by way of other
// registers.
HWY_INLINE void sort_word(const float* row, const Edges& edges, std::uint64_t* columns) {
    const size_t last = edges.bins - 1;
    auto* to = reinterpret_cast<char*>(columns);
    for (size_t i = 0; i < 32; i += lanes, to += lanes / 8) {
        Piece low(row + i), high(row + i + 32);
#pragma GCC unroll 9
        for (size_t b = 0; b < most_bins - 1; ++b) {
            if (b == last) break;
            const VF edge = hn::Set(f, edges.edge[b]);
            low.store_below(edge, to + b * sizeof *columns);
            high.store_below(edge, to + b * sizeof *columns + 4);
        }
    }
}
#endif

constexpr size_t together = 8;  // columns that are compared with others at once, at most

using B = hn::ScalableTag<std::uint8_t>;
using W = hn::ScalableTag<std::uint64_t>;
constexpr size_t word_lanes = hn::MaxLanes(W());

// Of `rows` columns with as many others as a vector holds words. Bits are counted in bytes, which
// hold those of 31 words.
template <size_t rows>
void count_some(const std::uint64_t* a, const std::uint64_t* b, size_t pitch, size_t words,
                std::uint32_t* to, size_t to_pitch) {
    constexpr B bytes;
    constexpr W whole;
    hn::Vec<W> sum[rows];
#pragma GCC unroll 8
    for (size_t o = 0; o < rows; ++o) sum[o] = hn::Zero(whole);
    for (size_t begin = 0; begin < words; begin += 31) {
        hn::Vec<B> bits[rows];
#pragma GCC unroll 8
        for (size_t o = 0; o < rows; ++o) bits[o] = hn::Zero(bytes);
        for (size_t w = begin; w < std::min(words, begin + 31); ++w) {
            const auto other = hn::LoadU(whole, b + w * pitch);
#pragma GCC unroll 8
            for (size_t o = 0; o < rows; ++o)
                bits[o] =
                    hn::Add(bits[o], hn::PopulationCount(hn::BitCast(
                                         bytes, hn::And(hn::Set(whole, a[w * pitch + o]), other))));
        }
        for (size_t o = 0; o < rows; ++o) sum[o] = hn::Add(sum[o], hn::SumsOf8(bits[o]));
    }
    for (size_t o = 0; o < rows; ++o) {
        std::uint64_t found[word_lanes];
        hn::StoreU(sum[o], whole, found);
        for (size_t k = 0; k < word_lanes; ++k) to[o * to_pitch + k] = std::uint32_t(found[k]);
    }
}

#if defined(__AVX512F__)
// The same where the processor counts bits itself, which not every one of this level does.
template <size_t rows>
__attribute__((target("avx512vpopcntdq"))) void count_some_natively(const std::uint64_t* a,
                                                                    const std::uint64_t* b,
                                                                    size_t pitch, size_t words,
                                                                    std::uint32_t* to,
                                                                    size_t to_pitch) {
    __m512i sum[rows];
#pragma GCC unroll 8
    for (size_t o = 0; o < rows; ++o) sum[o] = _mm512_setzero_si512();
    for (size_t w = 0; w < words; ++w) {
        const __m512i other = _mm512_loadu_si512(b + w * pitch);
#pragma GCC unroll 8
        for (size_t o = 0; o < rows; ++o) {
            const __m512i mine = _mm512_set1_epi64(static_cast<long long>(a[w * pitch + o]));
            sum[o] = _mm512_add_epi64(sum[o], _mm512_popcnt_epi64(_mm512_and_si512(mine, other)));
        }
    }
#pragma GCC unroll 8
    for (size_t o = 0; o < rows; ++o)
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + o * to_pitch),
                            _mm512_cvtepi64_epi32(sum[o]));
}
#endif

// By how many columns there are but one.
using CountSome = void(const std::uint64_t* a, const std::uint64_t* b, size_t pitch, size_t words,
                       std::uint32_t* to, size_t to_pitch);
const auto count_some_of = []<size_t... row>(std::index_sequence<row...>) {
#if defined(__AVX512F__)
    if (__builtin_cpu_supports("avx512vpopcntdq"))
        return std::array<CountSome*, together>{&count_some_natively<row + 1>...};
#endif
    return std::array<CountSome*, together>{&count_some<row + 1>...};
}
(std::make_index_sequence<together>());

}  // namespace

void sort_into_bins(const float* row, size_t n, const Edges& edges, std::uint64_t* columns,
                    size_t pitch) {
    size_t begin = 0;
    for (; begin + 64 <= n; begin += 64, columns += pitch) sort_word(row + begin, edges, columns);
    if (begin == n) return;
    float rest[64] = {};
    std::copy(row + begin, row + n, rest);
    sort_word(rest, edges, columns);
    for (size_t b = 0; b + 1 < edges.bins; ++b) columns[b] &= (std::uint64_t(1) << (n - begin)) - 1;
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
    // Groups as equal as they can be.
    for (size_t i = 0, groups = (rows + together - 1) / together; groups > 0; --groups) {
        const size_t some = (rows - i + groups - 1) / groups;
        for (size_t j = 0; j < columns; j += word_lanes)
            count_some_of[some - 1](a + i, b + j, pitch, words, counts + i * counts_pitch + j,
                                    counts_pitch);
        i += some;
    }
}

}  // namespace weft::rpf::WEFT_ISA
