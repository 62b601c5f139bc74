// The bilateral filter over samples: each of a block's own becomes the mean of its neighbourhood,
// by likeness.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "rpf/kernels.h"
#include "rpf/simd.h"

namespace weft::rpf::WEFT_ISA {
namespace {

// 2^-x for any x >= 0, to 3e-6 of itself; what is past 120 is as good as nothing. 2^r for |r| <=
// 1/2 by the polynomial of degree 4 that is 1 at 0 and whose largest relative error is the least.
// What is added rounds to whole numbers, which then are the last bits.
HWY_INLINE VF power_of_half(VF x) {
    const hn::RebindToSigned<F> whole;
    const VF y = hn::Min(x, hn::Set(f, 120.0f)), large = hn::Set(f, 0x1.8p23f);
    const VF n = hn::Add(y, large), r = hn::Sub(hn::Sub(n, large), y);
    VF p = hn::Set(f, 9.5828532e-3f);
    for (const float term : {5.5906425e-2f, 0.24024099f, 0.69312419f, 1.0f})
        p = hn::MulAdd(p, r, hn::Set(f, term));
    return hn::BitCast(f, hn::Sub(hn::BitCast(whole, p), hn::ShiftLeft<23>(hn::BitCast(whole, n))));
}

constexpr size_t together = lanes == 16 ? 8 : 4;  // own samples, as many as there are registers for
constexpr size_t at_once = 2;                     // vectors of neighbours
constexpr size_t run = 64;  // neighbours whose weights are kept until they are summed up

using Row = FilterScratch::Row;

// Of some rows `together` own samples' numbers, row by row, doubled and of the other sign; and the
// sum of each one's squares.
struct Own {
    const float *numbers, *squares;
};

// Those of own samples i on, as far as there are `own`, in rows [begin, end).
HWY_INLINE Own take_own(const Row* begin, const Row* end, size_t i, size_t own, float* numbers,
                        float* squares) {
    std::fill_n(squares, together, 0.0f);
    float* to = numbers;
    for (; begin < end; ++begin)
        for (size_t o = 0; o < together; ++o) {
            const float x = (begin->numbers[std::min(i + o, own - 1)] - begin->mean) * begin->root;
            squares[o] += x * x;
            *to++ = -2 * x;
        }
    return {numbers, squares};
}

// put(o, v, d) for the squared distances of own sample o to vector v of the others from the j-th
// on, in rows [begin, end). They are a^2 - 2 a b + b^2, where rounding does little harm: numbers
// are small, as they are taken from the own ones' mean.
template <class Put>
HWY_INLINE void distances(const Row* begin, const Row* end, Own own, size_t j, Put&& put) {
    VF sums[at_once][together], squares[at_once];
    for (size_t v = 0; v < at_once; ++v) {
        squares[v] = hn::Zero(f);
        for (size_t o = 0; o < together; ++o) sums[v][o] = hn::Set(f, own.squares[o]);
    }
    for (; begin < end; ++begin, own.numbers += together) {
        const VF mean = hn::Set(f, begin->mean), root = hn::Set(f, begin->root);
        VF x[at_once];
        for (size_t v = 0; v < at_once; ++v) {
            x[v] = hn::Mul(hn::Sub(hn::LoadU(f, begin->numbers + j + v * lanes), mean), root);
            squares[v] = hn::MulAdd(x[v], x[v], squares[v]);
        }
        for (size_t o = 0; o < together; ++o) {
            const VF mine = hn::Set(f, own.numbers[o]);
            for (size_t v = 0; v < at_once; ++v) sums[v][o] = hn::MulAdd(x[v], mine, sums[v][o]);
        }
    }
    for (size_t o = 0; o < together; ++o)
        for (size_t v = 0; v < at_once; ++v)
            put(o, v, hn::Max(hn::Add(sums[v][o], squares[v]), hn::Zero(f)));
}

float mean_of(const float* row, size_t n) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i) sum += double(row[i]);
    return float(sum / double(n));
}

// What is summed up over the neighbours of one own sample.
class Mean {
  public:
    HWY_INLINE Mean() { std::fill_n(sums_, 5, hn::Zero(f)); }
    HWY_INLINE void add(VF w, VF r, VF g, VF b) {
        sums_[0] = hn::Add(sums_[0], w);
        sums_[1] = hn::MulAdd(w, w, sums_[1]);
        sums_[2] = hn::MulAdd(w, r, sums_[2]);
        sums_[3] = hn::MulAdd(w, g, sums_[3]);
        sums_[4] = hn::MulAdd(w, b, sums_[4]);
    }
    HWY_INLINE void get(float* rgb, float& effective) const {
        const float w = sum_of(sums_[0]), per = 1 / w;
        for (size_t c = 0; c < 3; ++c) rgb[c] = sum_of(sums_[2 + c]) * per;
        effective = w * w / sum_of(sums_[1]);
    }

  private:
    VF sums_[5];
};

// Colours of all samples, 0 from n to whole vectors.
struct Planes {
    const float *r, *g, *b;
};
HWY_NOINLINE Planes find_colors(const Neighbourhoods& around, const float* rgb,
                                FilterScratch& scratch) {
    if (rgb == around.vectors->samples.rgb().data())  // are rows already
        return {around.row(around.color_row(0)), around.row(around.color_row(1)),
                around.row(around.color_row(2))};
    const size_t n = around.samples();
    for (std::vector<float>* plane : {&scratch.r, &scratch.g, &scratch.b}) {
        plane->resize(around.pitch);
        std::fill(plane->begin() + std::ptrdiff_t(n), plane->end(), 0.0f);
    }
    for (size_t j = 0; j < n; ++j) {
        const float* c = rgb + 3 * size_t(around.sample[j]);
        scratch.r[j] = c[0];
        scratch.g[j] = c[1];
        scratch.b[j] = c[2];
    }
    return {scratch.r.data(), scratch.g.data(), scratch.b.data()};
}

}  // namespace

void filter(const Neighbourhoods& around, const Weights& weights, const float* rgb,
            const Likeness& likeness, FilterScratch& scratch, SampleColors& out) {
    const size_t n = around.samples(), own = around.own();
    constexpr float log2_e = std::numbers::log2e_v<float>;
    // Features first, then colours.
    std::vector<Row>& rows = scratch.rows;
    rows.clear();
    size_t features = 0;
    for (size_t k = 0; k < around.rows(); ++k) {
        const float factor = weights.of_row[k] * likeness.scale * log2_e;
        if (!(factor > 0) || !(around.scale[k] > 0)) continue;
        rows.push_back(
            {around.row(k), mean_of(around.row(k), own), around.scale[k] * std::sqrt(factor)});
        if (k < around.color_row(0)) features = rows.size();
    }
    const Row *const begin = rows.data(), *const middle = begin + features,
                     *const end = begin + rows.size();
    const Planes colors = find_colors(around, rgb, scratch);

    const VF cutoff = hn::Set(f, likeness.cutoff * log2_e);
    scratch.own.resize(rows.size() * together + 1);
    scratch.weights.resize(together * run);
    float* const w = scratch.weights.data();
    for (size_t i = 0; i < own; i += together) {
        float squares_of_features[together], squares_of_colors[together];
        const Own by_feature =
                      take_own(begin, middle, i, own, scratch.own.data(), squares_of_features),
                  by_color = take_own(middle, end, i, own, &scratch.own[features * together],
                                      squares_of_colors);
        Mean mean[together];
        for (size_t first = 0; first < n; first += run) {
            const size_t last = std::min(n, first + run);
            const auto weight = [&](size_t o, size_t j) { return w + o * run + j - first; };
            for (size_t j = first; j < last; j += at_once * lanes) {
                const auto weigh = [&](size_t o, size_t v, auto near, VF exponent) HWY_ATTR {
                    const size_t at = j + v * lanes;
                    const auto there = hn::FirstN(f, at < n ? n - at : 0);
                    hn::StoreU(hn::IfThenElseZero(hn::And(there, near), power_of_half(exponent)), f,
                               weight(o, at));
                };
                if (middle == end) {  // colours often have no say
                    distances(begin, middle, by_feature, j, [&](size_t o, size_t v, VF d) HWY_ATTR {
                        weigh(o, v, hn::Lt(d, cutoff), d);
                    });
                    continue;
                }
                distances(begin, middle, by_feature, j, [&](size_t o, size_t v, VF d) HWY_ATTR {
                    hn::StoreU(d, f, weight(o, j + v * lanes));
                });
                distances(middle, end, by_color, j, [&](size_t o, size_t v, VF d) HWY_ATTR {
                    const VF features_too = hn::LoadU(f, weight(o, j + v * lanes));
                    weigh(o, v, hn::And(hn::Lt(features_too, cutoff), hn::Lt(d, cutoff)),
                          hn::Add(features_too, d));
                });
            }
            for (size_t o = 0; o < together; ++o) {
                Mean sum = mean[o];
                for (size_t j = first; j < last; j += lanes)
                    sum.add(hn::LoadU(f, weight(o, j)), hn::LoadU(f, colors.r + j),
                            hn::LoadU(f, colors.g + j), hn::LoadU(f, colors.b + j));
                mean[o] = sum;
            }
        }
        for (size_t o = 0; o < together && i + o < own; ++o)
            mean[o].get(&out.rgb[3 * (i + o)], out.effective[i + o]);
    }
}

}  // namespace weft::rpf::WEFT_ISA
