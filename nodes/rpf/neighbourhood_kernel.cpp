// Which samples belong to a neighbourhood, and their numbers as rows.
#include <algorithm>
#include <cmath>

#include <hwy/cache_control.h>

#include "rpf/kernels.h"
#include "rpf/simd.h"

namespace weft::rpf::WEFT_ISA {

namespace {

// Records lie too far apart for the processor to see them coming.
HWY_INLINE void fetch(const float* records, size_t stride, std::span<const std::uint32_t> which,
                      size_t i) {
    constexpr size_t ahead = 16, line = 16;
    const float* next = records + size_t(which[std::min(i + ahead, which.size() - 1)]) * stride;
    for (size_t k = 0; k < stride; k += line) hwy::Prefetch(next + k);
}

}  // namespace

// One comparison of whole vectors, features first: what is not clustered has an infinite bound.
size_t accept(const SampleVectors& vectors, std::span<const std::uint32_t> candidates,
              const float* centre, const float* bound, std::uint32_t* accepted) {
    size_t first = vectors.components.size(), last = 0;
    for (size_t k = 0; k < vectors.components.size(); ++k)
        if (!(bound[k] > 3e38f)) {
            first = std::min(first, k);
            last = k + 1;
        }
    size_t found = 0;
    const auto take = [&](auto&& inside) HWY_ATTR {
        for (size_t i = 0; i < candidates.size(); ++i) {
            fetch(vectors.values.data(), vectors.stride, candidates, i);
            accepted[found] = candidates[i];
            found += inside(vectors.of(candidates[i]));
        }
    };
    const auto within = [&](const float* of, size_t k) HWY_ATTR {
        return hn::Le(hn::Abs(hn::Sub(hn::LoadU(f, of + k), hn::LoadU(f, centre + k))),
                      hn::LoadU(f, bound + k));
    };
    if (last <= first + lanes) {
        take([&](const float* of) HWY_ATTR { return hn::AllTrue(f, within(of, first)); });
    } else if (last <= first + 2 * lanes) {
        take([&](const float* of) HWY_ATTR {
            return hn::AllTrue(f, hn::And(within(of, first), within(of, first + lanes)));
        });
    } else {
        take([&](const float* of) HWY_ATTR {
            bool inside = true;
            for (size_t k = first; k < last; k += lanes) inside &= hn::AllTrue(f, within(of, k));
            return inside;
        });
    }
    return found;
}

namespace {

// Four numbers each of four records, or of eight, those of the later four in the upper half.
#if HWY_TARGET == HWY_SSE4
using Records = hn::FixedTag<float, 4>;
#else
using Records = hn::FixedTag<float, 8>;
#endif
constexpr Records part{};
constexpr size_t records_at_once = hn::MaxLanes(Records());

HWY_INLINE hn::Vec<Records> numbers(const float* const* of, size_t i, size_t k) {
#if HWY_TARGET == HWY_SSE4
    return hn::LoadU(part, of[i] + k);
#else
    const hn::Half<Records> half;
    return hn::Combine(part, hn::LoadU(half, of[i + 4] + k), hn::LoadU(half, of[i] + k));
#endif
}

}  // namespace

// Blocks of records by four numbers at a time: what lies side by side in a record comes to lie side
// by side in a row.
void lay_out(const float* records, size_t stride, std::span<const std::uint32_t> which,
             size_t pitch, float* rows) {
    const hn::Repartition<double, Records> pairs;
    const auto of = [&](size_t i) { return records + size_t(which[i]) * stride; };
    const size_t n = which.size(), whole = n / records_at_once * records_at_once;
    for (size_t i = 0; i < whole; i += records_at_once) {
        const float* block[records_at_once];
        for (size_t j = 0; j < records_at_once; ++j) block[j] = of(i + j);
        float* to = rows + i;
        for (size_t k = 0; k < stride; k += 4, to += 4 * pitch) {
            const auto a = numbers(block, 0, k), b = numbers(block, 1, k), c = numbers(block, 2, k),
                       d = numbers(block, 3, k);
            const auto ab0 = hn::BitCast(pairs, hn::InterleaveLower(part, a, b)),
                       ab1 = hn::BitCast(pairs, hn::InterleaveUpper(part, a, b));
            const auto cd0 = hn::BitCast(pairs, hn::InterleaveLower(part, c, d)),
                       cd1 = hn::BitCast(pairs, hn::InterleaveUpper(part, c, d));
            hn::StoreU(hn::BitCast(part, hn::InterleaveLower(pairs, ab0, cd0)), part, to);
            hn::StoreU(hn::BitCast(part, hn::InterleaveUpper(pairs, ab0, cd0)), part, to + pitch);
            hn::StoreU(hn::BitCast(part, hn::InterleaveLower(pairs, ab1, cd1)), part,
                       to + 2 * pitch);
            hn::StoreU(hn::BitCast(part, hn::InterleaveUpper(pairs, ab1, cd1)), part,
                       to + 3 * pitch);
        }
    }
    for (size_t i = whole; i < n; ++i)
        for (size_t k = 0; k < stride; ++k) rows[k * pitch + i] = of(i)[k];
    for (size_t row = 0; row < stride; ++row)
        std::fill(rows + row * pitch + n, rows + (row + 1) * pitch, 0.0f);
}

namespace {

// Rows that are gone through together, as one sum alone waits for itself.
constexpr size_t rows_at_once = 4;

template <size_t rows>
HWY_INLINE void normalise_some(float* const* row, size_t n, float* mean, float* scale, float* low,
                               float* high) {
    // Vector by vector; of the last those numbers that there are.
    const auto each = [&](auto&& step) HWY_ATTR {
        size_t i = 0;
        for (; i + lanes <= n; i += lanes) step(i, [](VF v) HWY_ATTR { return v; });
        if (i < n)
            step(i, [&](VF v) HWY_ATTR { return hn::IfThenElseZero(hn::FirstN(f, n - i), v); });
    };
    // Moved by its first number, so that sums keep their digits where a row hardly varies.
    VF base[rows], sum[rows], least[rows], most[rows];
    for (size_t r = 0; r < rows; ++r) {
        base[r] = hn::Set(f, row[r][0]);
        sum[r] = least[r] = most[r] = hn::Zero(f);
    }
    each([&](size_t i, auto&& present) HWY_ATTR {
        for (size_t r = 0; r < rows; ++r) {
            const VF x = present(hn::Sub(hn::LoadU(f, row[r] + i), base[r]));
            sum[r] = hn::Add(sum[r], x);
            least[r] = hn::Min(least[r], x);
            most[r] = hn::Max(most[r], x);
        }
    });
    float off[rows];
    VF centre[rows], squares[rows];
    for (size_t r = 0; r < rows; ++r) {
        off[r] = sum_of(sum[r]) / float(n);
        mean[r] = row[r][0] + off[r];
        centre[r] = hn::Set(f, mean[r]);
        squares[r] = hn::Zero(f);
    }
    each([&](size_t i, auto&& present) HWY_ATTR {
        for (size_t r = 0; r < rows; ++r) {
            const VF x = present(hn::Sub(hn::LoadU(f, row[r] + i), centre[r]));
            squares[r] = hn::MulAdd(x, x, squares[r]);
        }
    });
    for (size_t r = 0; r < rows; ++r) {
        const float deviation = std::sqrt(sum_of(squares[r]) / std::max(1.0f, float(n) - 1));
        // What is less than rounding is no variation.
        const bool varies = deviation > 1e-6f * std::max(std::abs(mean[r]), 1e-6f);
        scale[r] = varies ? 1 / deviation : 0.0f;
        low[r] = (hn::GetLane(hn::MinOfLanes(f, least[r])) - off[r]) * scale[r];
        high[r] = (hn::GetLane(hn::MaxOfLanes(f, most[r])) - off[r]) * scale[r];
        const VF by = hn::Set(f, scale[r]);
        each([&](size_t i, auto&& present) HWY_ATTR {
            hn::StoreU(present(hn::Mul(hn::Sub(hn::LoadU(f, row[r] + i), centre[r]), by)), f,
                       row[r] + i);
        });
    }
}

}  // namespace

void normalise(float* rows, size_t count, size_t n, size_t pitch, float* mean, float* scale,
               float* low, float* high) {
    size_t k = 0;
    for (; k + rows_at_once <= count; k += rows_at_once) {
        float* const row[rows_at_once] = {rows + k * pitch, rows + (k + 1) * pitch,
                                          rows + (k + 2) * pitch, rows + (k + 3) * pitch};
        normalise_some<rows_at_once>(row, n, mean + k, scale + k, low + k, high + k);
    }
    for (; k < count; ++k) {
        float* const row[1] = {rows + k * pitch};
        normalise_some<1>(row, n, mean + k, scale + k, low + k, high + k);
    }
}

}  // namespace weft::rpf::WEFT_ISA
