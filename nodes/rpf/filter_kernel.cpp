// The bilateral filter over samples: each of a block's own becomes the mean of its neighbourhood,
// by likeness.
#include <algorithm>
#include <cmath>

#include "rpf/kernels.h"
#include "rpf/simd.h"

namespace weft::rpf::WEFT_ISA {
namespace {

// e^-x for any x >= 0; what is past 80 is as good as nothing.
HWY_INLINE VF falling(VF x) {
    return exp_of_minus(hn::Min(x, hn::Set(f, 80.0f)));
}

constexpr size_t together = lanes == 16 ? 8 : 4;  // own samples, as many as there are registers for

// Distances of `together` own samples to those from j on, over some rows.
HWY_INLINE void distances(const float* rows, size_t pitch, std::span<const std::uint32_t> which,
                          const std::uint32_t* own, size_t j, VF* sums) {
    for (size_t o = 0; o < together; ++o) sums[o] = hn::Zero(f);
    for (const std::uint32_t k : which) {
        const float* row = rows + size_t(k) * pitch;
        const VF x = hn::LoadU(f, row + j);
        for (size_t o = 0; o < together; ++o) {
            const VF d = hn::Sub(x, hn::Set(f, row[own[o]]));
            sums[o] = hn::MulAdd(d, d, sums[o]);
        }
    }
}

}  // namespace

void filter(const Neighbourhoods& around, const Weights& weights, const float* rgb,
            const Likeness& likeness, FilterScratch& scratch, SampleColors& out) {
    const size_t n = around.samples(), own = around.own(), pitch = around.pitch;
    // Rows that count, each times the root of its weight, so that the loop over pairs only squares
    // and adds.
    scratch.features.clear();
    scratch.colors.clear();
    size_t used = 0;
    scratch.rows.resize(around.rows() * pitch);
    for (size_t k = 0; k < around.rows(); ++k) {
        const float factor = weights.of_row[k] * likeness.scale;
        if (!(factor > 0) || !(around.scale[k] > 0)) continue;
        const VF root = hn::Set(f, std::sqrt(factor));
        const float* from = around.row(k);
        float* to = &scratch.rows[used * pitch];
        for (size_t j = 0; j < pitch; j += lanes)
            hn::StoreU(hn::Mul(hn::LoadU(f, from + j), root), f, to + j);
        (k >= around.color_row(0) ? scratch.colors : scratch.features)
            .push_back(std::uint32_t(used++));
    }
    for (std::vector<float>* plane : {&scratch.r, &scratch.g, &scratch.b}) {
        plane->resize(pitch);
        std::fill(plane->begin() + std::ptrdiff_t(n), plane->end(), 0.0f);
    }
    for (size_t j = 0; j < n; ++j) {
        const float* c = rgb + 3 * size_t(around.sample[j]);
        scratch.r[j] = c[0];
        scratch.g[j] = c[1];
        scratch.b[j] = c[2];
    }

    const VF cutoff = hn::Set(f, likeness.cutoff), zero = hn::Zero(f);
    for (size_t i = 0; i < own; i += together) {
        std::uint32_t index[together];
        for (size_t o = 0; o < together; ++o) index[o] = std::uint32_t(std::min(i + o, own - 1));
        VF sum_w[together], sum_ww[together], sum_r[together], sum_g[together], sum_b[together];
        for (size_t o = 0; o < together; ++o)
            sum_w[o] = sum_ww[o] = sum_r[o] = sum_g[o] = sum_b[o] = zero;
        for (size_t j = 0; j < n; j += lanes) {
            VF features[together], colors[together];
            distances(scratch.rows.data(), pitch, scratch.features, index, j, features);
            distances(scratch.rows.data(), pitch, scratch.colors, index, j, colors);
            const auto there = hn::FirstN(f, std::min(lanes, n - j));
            const VF r = hn::LoadU(f, &scratch.r[j]), g = hn::LoadU(f, &scratch.g[j]),
                     b = hn::LoadU(f, &scratch.b[j]);
            for (size_t o = 0; o < together; ++o) {
                const auto near =
                    hn::And(there, hn::And(hn::Lt(features[o], cutoff), hn::Lt(colors[o], cutoff)));
                if (hn::AllFalse(f, near)) continue;
                const VF w = hn::IfThenElseZero(near, falling(hn::Add(features[o], colors[o])));
                sum_w[o] = hn::Add(sum_w[o], w);
                sum_ww[o] = hn::MulAdd(w, w, sum_ww[o]);
                sum_r[o] = hn::MulAdd(w, r, sum_r[o]);
                sum_g[o] = hn::MulAdd(w, g, sum_g[o]);
                sum_b[o] = hn::MulAdd(w, b, sum_b[o]);
            }
        }
        for (size_t o = 0; o < together && i + o < own; ++o) {
            const float w = sum_of(sum_w[o]), ww = sum_of(sum_ww[o]), per = 1 / w;
            float* to = &out.rgb[3 * (i + o)];
            to[0] = sum_of(sum_r[o]) * per;
            to[1] = sum_of(sum_g[o]) * per;
            to[2] = sum_of(sum_b[o]) * per;
            out.effective[i + o] = w * w / ww;
        }
    }
}

}  // namespace weft::rpf::WEFT_ISA
