// Which samples belong to a neighbourhood, and their numbers as rows.
#include <algorithm>
#include <cmath>

#include <hwy/cache_control.h>

#include "rpf/kernels.h"
#include "rpf/simd.h"

namespace weft::rpf::WEFT_ISA {

namespace {

// Four numbers each of as many records as a vector has quarters: those 0, 4, 8 and 12 on.
constexpr hn::FixedTag<float, 4> four{};
HWY_INLINE VF numbers(const float* const* of, size_t k) {
#if HWY_TARGET == HWY_SSE4
    return hn::LoadU(four, of[0] + k);
#else
    constexpr hn::FixedTag<float, 8> eight{};
    const auto low = hn::Combine(eight, hn::LoadU(four, of[4] + k), hn::LoadU(four, of[0] + k));
#if HWY_TARGET == HWY_AVX2
    return low;
#else
    return hn::Combine(
        f, hn::Combine(eight, hn::LoadU(four, of[12] + k), hn::LoadU(four, of[8] + k)), low);
#endif
#endif
}

// What lies side by side in records, side by side in rows: numbers k to k + 3 of a vector of
// records.
HWY_INLINE void turn(const float* const* of, size_t k, VF* row) {
    constexpr hn::Repartition<double, F> pairs{};
    const VF a = numbers(of, k), b = numbers(of + 1, k), c = numbers(of + 2, k),
             d = numbers(of + 3, k);
    const auto ab0 = hn::BitCast(pairs, hn::InterleaveLower(f, a, b)),
               ab1 = hn::BitCast(pairs, hn::InterleaveUpper(f, a, b)),
               cd0 = hn::BitCast(pairs, hn::InterleaveLower(f, c, d)),
               cd1 = hn::BitCast(pairs, hn::InterleaveUpper(f, c, d));
    row[0] = hn::BitCast(f, hn::InterleaveLower(pairs, ab0, cd0));
    row[1] = hn::BitCast(f, hn::InterleaveUpper(pairs, ab0, cd0));
    row[2] = hn::BitCast(f, hn::InterleaveLower(pairs, ab1, cd1));
    row[3] = hn::BitCast(f, hn::InterleaveUpper(pairs, ab1, cd1));
}

constexpr size_t rows_at_once = 4, records_at_once = 128;

// Of a row, lane by lane, by differences to its first number, so that sums keep their digits where
// it hardly varies.
struct Sums {
    VF sum, squares, least, most;
};
constexpr size_t of_sums = 4 * lanes;  // numbers

HWY_INLINE Sums load_sums(const float* from) {
    return {hn::LoadU(f, from), hn::LoadU(f, from + lanes), hn::LoadU(f, from + 2 * lanes),
            hn::LoadU(f, from + 3 * lanes)};
}
HWY_INLINE void store_sums(const Sums& s, float* to) {
    hn::StoreU(s.sum, f, to);
    hn::StoreU(s.squares, f, to + lanes);
    hn::StoreU(s.least, f, to + 2 * lanes);
    hn::StoreU(s.most, f, to + 3 * lanes);
}

// Four rows of some records, `last` of which are of the last vector.
HWY_INLINE void lay_out_some(const float* const* of, size_t vectors, size_t last, size_t k,
                             const float* first, size_t pitch, float* rows, float* sums) {
    VF base[rows_at_once];
    Sums s[rows_at_once];
    for (size_t r = 0; r < rows_at_once; ++r) {
        base[r] = hn::Set(f, first[k + r]);
        s[r] = load_sums(sums + r * of_sums);
    }
    const auto add = [&](size_t v, auto&& present) HWY_ATTR {
        VF row[rows_at_once];
        turn(of + v * lanes, k, row);
        for (size_t r = 0; r < rows_at_once; ++r) {
            hn::StoreU(present(row[r]), f, rows + r * pitch + v * lanes);
            const VF x = present(hn::Sub(row[r], base[r]));
            s[r].sum = hn::Add(s[r].sum, x);
            s[r].squares = hn::MulAdd(x, x, s[r].squares);
            s[r].least = hn::Min(s[r].least, x);
            s[r].most = hn::Max(s[r].most, x);
        }
    };
    const size_t whole = vectors - (last < lanes);
    for (size_t v = 0; v < whole; ++v) add(v, [](VF x) HWY_ATTR { return x; });
    if (whole < vectors)
        add(whole, [&](VF x) HWY_ATTR { return hn::IfThenElseZero(hn::FirstN(f, last), x); });
    for (size_t r = 0; r < rows_at_once; ++r) store_sums(s[r], sums + r * of_sums);
}

// The rows of a neighbourhood, as its samples are found.
class Rows {
  public:
    Rows(const SampleVectors& vectors, LayoutScratch& scratch, Neighbourhoods& out)
        : vectors_(vectors),
          scratch_(scratch),
          out_(out),
          rows_((vectors.stride() + rows_at_once - 1) / rows_at_once * rows_at_once) {
        out.values.resize(rows_ * out.pitch + Neighbourhoods::padding);
        for (auto* of_row : {&out.mean, &out.scale, &out.low, &out.high})
            of_row->assign(vectors.stride(), 0.0f);
        scratch.sums.assign(rows_ * of_sums, 0.0f);
    }

    // Those of the first n samples that are not yet there; only as many as are laid out at once,
    // unless they are `all`.
    HWY_NOINLINE void add(size_t n, bool all) {
        while (done_ < n && (all || n - done_ >= records_at_once)) {
            const size_t some = std::min(records_at_once, n - done_),
                         vectors = (some + lanes - 1) / lanes;
            const float* const first = vectors_.of(out_.sample[0]);
            const float* of[records_at_once + lanes];
            for (size_t i = 0; i < some; ++i) of[i] = vectors_.of(out_.sample[done_ + i]);
            std::fill(of + some, of + vectors * lanes, first);
            for (size_t k = 0; k < rows_; k += rows_at_once)
                lay_out_some(of, vectors, some - (vectors - 1) * lanes, k, first, out_.pitch,
                             &out_.values[k * out_.pitch + done_], &scratch_.sums[k * of_sums]);
            done_ += some;
        }
    }

    // What they come to.
    void finish() {
        if (done_ == 0) return;
        const auto n = double(done_);
        const float* const first = vectors_.of(out_.sample[0]);
        for (size_t k = 0; k < vectors_.stride(); ++k) {
            const Sums s = load_sums(&scratch_.sums[k * of_sums]);
            const double sum = double(sum_of(s.sum)), squares = double(sum_of(s.squares)),
                         off = sum / n, mean = double(first[k]) + off;
            const double deviation =
                std::sqrt(std::max(0.0, squares - sum * off) / std::max(1.0, n - 1));
            // What is less than rounding is no variation.
            const bool varies = deviation > 1e-6 * std::max(std::abs(mean), 1e-6);
            const double scale = varies ? 1 / deviation : 0;
            out_.mean[k] = float(mean);
            out_.scale[k] = float(scale);
            out_.low[k] = float((double(hn::GetLane(hn::MinOfLanes(f, s.least))) - off) * scale);
            out_.high[k] = float((double(hn::GetLane(hn::MaxOfLanes(f, s.most))) - off) * scale);
        }
    }

  private:
    const SampleVectors& vectors_;
    LayoutScratch& scratch_;
    Neighbourhoods& out_;
    size_t rows_, done_ = 0;
};

// One comparison of whole vectors, features first: what is not clustered has an infinite bound.
class Near {
  public:
    Near(const SampleVectors& vectors, const float* centre, const float* bound)
        : vectors_(vectors), centre_(centre), bound_(bound), first_(vectors.components.size()) {
        for (size_t k = 0; k < vectors.components.size(); ++k)
            if (!(bound[k] > 3e38f)) {
                first_ = std::min(first_, k);
                last_ = k + 1;
            }
    }
    // Of candidates [begin, end).
    HWY_INLINE size_t take(std::span<const std::uint32_t> candidates, size_t begin, size_t end,
                           std::uint32_t* to) const {
        if (last_ <= first_ + lanes) return compare<1>(candidates, begin, end, to);
        if (last_ <= first_ + 2 * lanes) return compare<2>(candidates, begin, end, to);
        if (last_ <= first_ + 3 * lanes) return compare<3>(candidates, begin, end, to);
        return compare<0>(candidates, begin, end, to);
    }

    // The same of candidates that are known to be near.
    HWY_INLINE size_t take_all(std::span<const std::uint32_t> candidates, size_t begin, size_t end,
                               std::uint32_t* to) const {
        std::copy(candidates.begin() + std::ptrdiff_t(begin),
                  candidates.begin() + std::ptrdiff_t(end), to);
        for (size_t c = begin + ahead; c < std::min(end + ahead, candidates.size()); ++c)
            fetch(candidates[c]);
        return end - begin;
    }

  private:
    static constexpr size_t ahead = 16;
    // `vectors` that are compared, or 0: as many as it takes.
    template <size_t vectors>
    HWY_NOINLINE size_t compare(std::span<const std::uint32_t> candidates, size_t begin, size_t end,
                                std::uint32_t* to) const {
        const size_t stride = vectors_.stride(), first = first_,
                     last = vectors > 0 ? first + vectors * lanes : last_;
        const float *const records = vectors_.values.data(), *const centre = centre_,
                           *const bound = bound_;
        size_t found = 0;
        const auto test = [&](size_t c) HWY_ATTR {
            const float* of = records + candidates[c] * stride;
            to[found] = candidates[c];
            auto inside = within(of + first, centre + first, bound + first);
            for (size_t k = first + lanes; k < last; k += lanes)
                inside = hn::And(inside, within(of + k, centre + k, bound + k));
            found += hn::AllTrue(f, inside);
        };
        size_t c = begin;
        for (const size_t seen = std::min(end + ahead, candidates.size()); c + ahead < seen; ++c) {
            fetch(candidates[c + ahead]);
            test(c);
        }
        for (; c < end; ++c) test(c);
        return found;
    }
    // Records lie too far apart for the processor to see them coming.
    HWY_INLINE void fetch(std::uint32_t candidate) const {
        const float* of = vectors_.of(candidate);
        for (size_t k = 0; k < vectors_.stride(); k += 16) hwy::Prefetch(of + k);
        hwy::Prefetch(of + vectors_.stride() - 1);
    }
    static HWY_INLINE auto within(const float* of, const float* centre, const float* bound) {
        return hn::Le(hn::Abs(hn::Sub(hn::LoadU(f, of), hn::LoadU(f, centre))),
                      hn::LoadU(f, bound));
    }
    const SampleVectors& vectors_;
    const float *centre_, *bound_;
    size_t first_, last_ = 0;
};

}  // namespace

void judge_pixels(std::span<const NearCodes> by, size_t pixel, size_t n, PixelNear* to) {
    constexpr hn::Repartition<std::uint8_t, F> bytes;
    constexpr size_t at_once = hn::MaxLanes(bytes);
    const auto as_byte = [](PixelNear near) HWY_ATTR { return hn::Set(bytes, std::uint8_t(near)); };
    const auto zero = hn::Zero(bytes);
    for (size_t i = 0; i < n; i += at_once) {
        // What is more than nothing once subtracted is greater.
        auto far = zero, out = zero;
        for (const NearCodes& of : by) {
            const auto past = [&](auto a, auto b) HWY_ATTR { return hn::SaturatedSub(a, b); };
            const auto low = hn::LoadU(bytes, of.low + pixel + i),
                       high = hn::LoadU(bytes, of.high + pixel + i);
            far = hn::Or(far, hn::Or(past(low, hn::Set(bytes, of.last)),
                                     past(hn::Set(bytes, of.first), high)));
            out = hn::Or(out, hn::Or(past(hn::Set(bytes, of.first_in), low),
                                     past(high, hn::Set(bytes, of.last_in))));
            if (hn::AllFalse(bytes, hn::Eq(far, zero))) break;
        }
        const auto near =
            hn::IfThenElse(hn::Eq(out, zero), as_byte(PixelNear::all), as_byte(PixelNear::some));
        hn::StoreU(hn::IfThenElseZero(hn::Eq(far, zero), near), bytes,
                   reinterpret_cast<std::uint8_t*>(to + i));
    }
}

// Some candidates at a time, whose records then are at hand when they are laid out.
void take_near(const SampleVectors& vectors, const DrawnSamples& drawn, const float* centre,
               const float* bound, LayoutScratch& scratch, Neighbourhoods& out) {
    Rows rows(vectors, scratch, out);
    const Near near(vectors, centre, bound);
    size_t n = out.sample.size(), i = 0;
    out.sample.resize(n + drawn.sample.size());
    for (const DrawnSamples::Stretch& stretch : drawn.stretches)
        while (i < stretch.end) {
            const size_t end = std::min(stretch.end, i + records_at_once);
            n += stretch.near == PixelNear::all
                     ? near.take_all(drawn.sample, i, end, &out.sample[n])
                     : near.take(drawn.sample, i, end, &out.sample[n]);
            i = end;
            rows.add(n, false);
        }
    out.sample.resize(n);
    rows.add(n, true);
    rows.finish();
}

namespace {

// Samples of pixels side by side, eight at a time, some of which are written whether taken or not:
// that is sooner done than asked.
constexpr hn::CappedTag<std::uint32_t, 8> eight{};
using V8 = hn::Vec<decltype(eight)>;
// to[i] = first + which(i) for i of the first n, and some more.
template <class Which>
HWY_INLINE std::uint32_t* take_some(size_t first, size_t n, Which&& which, std::uint32_t* to) {
    size_t i = 0;
    do {
        const V8 numbers = hn::Add(hn::Set(eight, std::uint32_t(i)), hn::Iota(eight, 0));
        hn::StoreU(hn::Add(hn::Set(eight, std::uint32_t(first)), which(numbers)), eight, to + i);
        i += hn::MaxLanes(eight);
    } while (i < n);
    return to + n;
}

// 32 bits to 32 bits, one to one, every input bit reaching every output bit (the finalizer of
// Appleby's MurmurHash3, 2011).
HWY_INLINE V8 mix(V8 x) {
    x = hn::Mul(hn::Xor(x, hn::ShiftRight<16>(x)), hn::Set(eight, 0x85ebca6bu));
    x = hn::Mul(hn::Xor(x, hn::ShiftRight<13>(x)), hn::Set(eight, 0xc2b2ae35u));
    return hn::Xor(x, hn::ShiftRight<16>(x));
}

}  // namespace

std::uint32_t* take_first(const Samples& samples, size_t pixel,
                          std::span<const std::uint16_t> counts, std::uint32_t* to) {
    for (const std::uint16_t count : counts) {
        const auto [begin, end] = samples.of_pixel(pixel++);
        to = take_some(
            begin, std::min<size_t>(count, end - begin), [](V8 number) HWY_ATTR { return number; },
            to);
    }
    return to;
}

std::uint32_t* take_any(const Samples& samples, size_t pixel, std::span<const std::uint16_t> counts,
                        std::uint32_t chance, std::uint32_t* to) {
    constexpr size_t most = 1 << 16;  // samples of a pixel that are told apart; more are not drawn
    for (const std::uint16_t count : counts) {
        const auto [begin, end] = samples.of_pixel(pixel);
        const V8 n = hn::Set(eight, std::uint32_t(std::min(end - begin, most - 1))),
                 key = hn::Set(eight, chance ^ std::uint32_t(pixel++) * 0x9e3779b1u);
        to = take_some(
            begin, end > begin ? count : 0,
            [&](V8 number) HWY_ATTR {
                const V8 bits = mix(hn::Xor(key, hn::Mul(number, hn::Set(eight, 0x85157af5u))));
                return hn::ShiftRight<16>(hn::Mul(hn::ShiftRight<16>(bits), n));
            },
            to);
    }
    return to;
}

}  // namespace weft::rpf::WEFT_ISA
