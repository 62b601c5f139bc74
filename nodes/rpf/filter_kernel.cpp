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
constexpr size_t run = 64;  // neighbours whose weights are kept until they are summed up

using Row = FilterScratch::Row;

// Of rows [begin, end) the squared distances of `together` own samples to a vector of others.
// `own`: their numbers, row by row.
HWY_INLINE void distances(const Row* begin, const Row* end, const float* own, size_t j, VF* sums) {
    for (size_t o = 0; o < together; ++o) sums[o] = hn::Zero(f);
    for (; begin < end; ++begin, own += together) {
        const VF x = hn::Mul(hn::Sub(hn::LoadU(f, begin->numbers + j), hn::Set(f, begin->mean)),
                             hn::Set(f, begin->root));
        for (size_t o = 0; o < together; ++o) {
            const VF d = hn::Sub(x, hn::Set(f, own[o]));
            sums[o] = hn::MulAdd(d, d, sums[o]);
        }
    }
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
        rows.push_back({around.row(k), around.mean[k], around.scale[k] * std::sqrt(factor)});
        if (k < around.color_row(0)) features = rows.size();
    }
    const Row *const begin = rows.data(), *const middle = begin + features,
                     *const end = begin + rows.size();
    const Planes colors = find_colors(around, rgb, scratch);

    const VF cutoff = hn::Set(f, likeness.cutoff * log2_e);
    scratch.own.resize(rows.size() * together);
    scratch.weights.resize(together * run);
    float *const mine = scratch.own.data(), *const w = scratch.weights.data();
    for (size_t i = 0; i < own; i += together) {
        for (size_t k = 0; k < rows.size(); ++k)
            for (size_t o = 0; o < together; ++o)
                mine[k * together + o] =
                    (rows[k].numbers[std::min(i + o, own - 1)] - rows[k].mean) * rows[k].root;
        Mean mean[together];
        for (size_t first = 0; first < n; first += run) {
            const size_t last = std::min(n, first + run);
            for (size_t j = first; j < last; j += lanes) {
                const auto there = hn::FirstN(f, std::min(lanes, n - j));
                const auto weigh = [&](size_t o, auto near, VF exponent) HWY_ATTR {
                    hn::StoreU(hn::IfThenElseZero(hn::And(there, near), power_of_half(exponent)), f,
                               w + o * run + j - first);
                };
                VF by_features[together];
                distances(begin, middle, mine, j, by_features);
                if (middle == end) {  // colours often have no say
                    for (size_t o = 0; o < together; ++o)
                        weigh(o, hn::Lt(by_features[o], cutoff), by_features[o]);
                    continue;
                }
                VF by_colors[together];
                distances(middle, end, mine + features * together, j, by_colors);
                for (size_t o = 0; o < together; ++o)
                    weigh(o, hn::And(hn::Lt(by_features[o], cutoff), hn::Lt(by_colors[o], cutoff)),
                          hn::Add(by_features[o], by_colors[o]));
            }
            for (size_t o = 0; o < together; ++o) {
                Mean sum = mean[o];
                for (size_t j = first; j < last; j += lanes)
                    sum.add(hn::LoadU(f, w + o * run + j - first), hn::LoadU(f, colors.r + j),
                            hn::LoadU(f, colors.g + j), hn::LoadU(f, colors.b + j));
                mean[o] = sum;
            }
        }
        for (size_t o = 0; o < together && i + o < own; ++o)
            mean[o].get(&out.rgb[3 * (i + o)], out.effective[i + o]);
    }
}

}  // namespace weft::rpf::WEFT_ISA
