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

// Of the samples of a pixel around, each by the pixel's weight and by how like its own features are
// to the sample's.
void average_samples(const SampleVectors& vectors, const float* colors, std::uint32_t own, int x,
                     int y, const PixelLikeness& by, const float* weights,
                     std::span<const float> factors, float* rgb, float* effective) {
    const PixelStatistics& p = vectors.pixels;
    const int width = p.planes.width;
    const float* mine = vectors.of(own) + p.first;
    const bool apart =
        std::any_of(factors.begin(), factors.end(), [](float factor) { return factor > 0; });
    float sum_w = 0, sum_ww = 0, sum[3] = {};
    for (int dy = std::max(-by.radius, -y); dy <= std::min(by.radius, p.planes.height - 1 - y);
         ++dy)
        for (int dx = std::max(-by.radius, -x); dx <= std::min(by.radius, width - 1 - x); ++dx) {
            const float pixel =
                weights[size_t(dy + by.radius) * by.pitch() + size_t(dx + by.radius)];
            if (!(pixel > 1e-4f)) continue;
            const auto [begin, end] =
                vectors.samples.of_pixel(size_t(y + dy) * size_t(width) + size_t(x + dx));
            for (size_t j = begin; j < end; ++j) {
                if (!vectors.is_whole(j)) continue;
                float w = pixel;
                if (apart) {
                    const float* other = vectors.of(j) + p.first;
                    VF square = hn::Zero(f);
                    for (size_t k = 0; k < factors.size(); k += lanes) {
                        const VF d =
                            hn::Mul(hn::Sub(hn::LoadU(f, other + k), hn::LoadU(f, mine + k)),
                                    hn::LoadU(f, &factors[k]));
                        square = hn::MulAdd(d, d, square);
                    }
                    const float distance = sum_of(square);
                    if (distance > 12) continue;
                    w *= std::exp(-distance);
                }
                sum_w += w;
                sum_ww += w * w;
                for (size_t c = 0; c < 3; ++c) sum[c] += w * colors[3 * j + c];
            }
        }
    for (size_t c = 0; c < 3; ++c) rgb[c] = sum[c] / sum_w;
    *effective = sum_w * sum_w / sum_ww;
}

}  // namespace weft::rpf::WEFT_ISA
