// Means over the pixels around, by weights that weigh_pixels() found.
#include <algorithm>
#include <cmath>

#include "rpf/kernels.h"
#include "rpf/simd.h"

namespace weft::rpf::WEFT_ISA {

// A pixel counts as often as it has samples.
void average_pixels(const SampleVectors& vectors, int x, int y, const PixelLikeness& by,
                    const float* weights, float* rgb, float* effective) {
    const PixelStatistics& p = vectors.pixels;
    const VF zero = hn::Zero(f);
    VF sum_w = zero, sum_ww = zero, sum[3] = {zero, zero, zero};
    for (int dy = std::max(-by.radius, -y); dy <= std::min(by.radius, p.planes.height - 1 - y);
         ++dy) {
        const float* row = weights + size_t(dy + by.radius) * by.pitch();
        const int from = x - by.radius;
        for (size_t i = 0; i < by.pitch(); i += lanes) {
            const VF each = hn::LoadU(f, row + i),
                     samples = hn::LoadU(f, p.planes.row(p.samples(), y + dy) + from + i),
                     w = hn::Mul(each, samples);
            sum_w = hn::Add(sum_w, w);
            sum_ww = hn::MulAdd(w, each, sum_ww);
            for (size_t c = 0; c < 3; ++c)
                sum[c] = hn::MulAdd(w, hn::LoadU(f, p.planes.row(p.color(c), y + dy) + from + i),
                                    sum[c]);
        }
    }
    const float total = sum_of(sum_w);
    for (size_t c = 0; c < 3; ++c) rgb[c] = sum_of(sum[c]) / total;
    *effective = total * total / sum_of(sum_ww) * float(vectors.samples.mean_spp());
}

namespace {

// Which samples the pixels around have, and these pixels' weights; up to whole vectors of weight 0.
size_t find_around(const SampleVectors& vectors, int x, int y, const PixelLikeness& by,
                   const float* weights, AroundScratch& around) {
    constexpr float least = 1e-4f;
    const int width = vectors.pixels.planes.width, height = vectors.pixels.planes.height;
    around.sample.clear();
    around.weight.clear();
    for (int dy = std::max(-by.radius, -y); dy <= std::min(by.radius, height - 1 - y); ++dy)
        for (int dx = std::max(-by.radius, -x); dx <= std::min(by.radius, width - 1 - x); ++dx) {
            const float weight =
                weights[size_t(dy + by.radius) * by.pitch() + size_t(dx + by.radius)];
            if (!(weight > least)) continue;
            const auto [begin, end] =
                vectors.samples.of_pixel(size_t(y + dy) * size_t(width) + size_t(x + dx));
            for (size_t j = begin; j < end; ++j) {
                if (!vectors.is_whole(j)) continue;
                around.sample.push_back(std::uint32_t(j));
                around.weight.push_back(weight);
            }
        }
    const size_t pitch = (around.sample.size() + lanes - 1) / lanes * lanes;
    around.weight.resize(pitch, 0.0f);
    return pitch;
}

}  // namespace

// What a pixel's samples have in common is laid out once: rows of colours, then of features, these
// less those of its first sample, as differences of small numbers keep their digits.
void average_samples(const SampleVectors& vectors, const float* colors,
                     std::span<const std::uint32_t> own, int x, int y, const PixelLikeness& by,
                     const float* weights, std::span<const float> factors, AroundScratch& around,
                     float* rgb, float* effective) {
    const size_t first = vectors.pixels.first,
                 pitch = find_around(vectors, x, y, by, weights, around);
    std::vector<size_t>& components = around.components;
    components.clear();
    for (size_t k = 0; k < factors.size(); ++k)
        if (factors[k] > 0) components.push_back(k);
    around.rows.assign((3 + components.size()) * pitch, 0.0f);
    const float* const base = vectors.of(own[0]) + first;
    for (size_t i = 0; i < around.sample.size(); ++i) {
        const float *color = colors + 3 * size_t(around.sample[i]),
                    *of = vectors.of(around.sample[i]) + first;
        float* to = &around.rows[i];
        for (size_t c = 0; c < 3; ++c, to += pitch) *to = color[c];
        for (const size_t k : components) {
            *to = (of[k] - base[k]) * factors[k];
            to += pitch;
        }
    }
    around.mine.resize(components.size());
    for (size_t o = 0; o < own.size(); ++o) {
        const float* of = vectors.of(own[o]) + first;
        for (size_t k = 0; k < components.size(); ++k)
            around.mine[k] = (of[components[k]] - base[components[k]]) * factors[components[k]];
        const VF zero = hn::Zero(f), far = hn::Set(f, 12.0f);
        VF sum_w = zero, sum_ww = zero, sum[3] = {zero, zero, zero};
        for (size_t i = 0; i < pitch; i += lanes) {
            const float* row = &around.rows[3 * pitch + i];
            VF distance = zero;
            for (const float mine : around.mine) {
                const VF d = hn::Sub(hn::LoadU(f, row), hn::Set(f, mine));
                distance = hn::MulAdd(d, d, distance);
                row += pitch;
            }
            const VF w = hn::IfThenElseZero(
                hn::Le(distance, far),
                hn::Mul(hn::LoadU(f, &around.weight[i]), exp_of_minus(hn::Min(distance, far))));
            sum_w = hn::Add(sum_w, w);
            sum_ww = hn::MulAdd(w, w, sum_ww);
            for (size_t c = 0; c < 3; ++c)
                sum[c] = hn::MulAdd(w, hn::LoadU(f, &around.rows[c * pitch + i]), sum[c]);
        }
        const float total = sum_of(sum_w);
        for (size_t c = 0; c < 3; ++c) rgb[3 * o + c] = sum_of(sum[c]) / total;
        effective[o] = total * total / sum_of(sum_ww);
    }
}

}  // namespace weft::rpf::WEFT_ISA
