// How like the pixels around are to each of a block's: a row of offsets at a time, a vector of them
// at once.
#include <algorithm>
#include <cmath>

#include "rpf/kernels.h"
#include "rpf/simd.h"

namespace weft::rpf::WEFT_ISA {
namespace {

// Distances of colours and where they are known, for every pixel of the block and around it and
// every offset.
class ColorDistances {
  public:
    ColorDistances(const PixelStatistics& p, PixelBlock block, const PixelLikeness& by,
                   PixelScratch& scratch)
        : p_(p),
          by_(by),
          scratch_(scratch),
          x0_(std::max(0, block.x0 - 1)),
          y0_(std::max(0, block.y0 - 1)),
          x1_(std::min(p.planes.width, block.x1 + 1)),
          y1_(std::min(p.planes.height, block.y1 + 1)) {
        const size_t pixels = size_t(x1_ - x0_) * size_t(y1_ - y0_);
        scratch.distances.resize(pixels * by.size());
        scratch.known.resize(pixels * by.size());
        for (int y = y0_; y < y1_; ++y)
            for (int x = x0_; x < x1_; ++x) find(x, y);
    }

    // The mean over the patch around (x, y), for the offset at `i`, which counts through rows of
    // offsets.
    HWY_INLINE VF mean(int x, int y, size_t i) const {
        VF sum = hn::Zero(f), known = hn::Zero(f);
        for (int b = std::max(y - 1, y0_); b <= std::min(y + 1, y1_ - 1); ++b)
            for (int a = std::max(x - 1, x0_); a <= std::min(x + 1, x1_ - 1); ++a) {
                sum = hn::Add(sum, hn::LoadU(f, &scratch_.distances[at(a, b) + i]));
                known = hn::Add(known, hn::LoadU(f, &scratch_.known[at(a, b) + i]));
            }
        return hn::Max(hn::Zero(f), hn::Div(sum, hn::Max(hn::Set(f, 1.0f), known)));
    }

  private:
    size_t at(int x, int y) const {
        return (size_t(y - y0_) * size_t(x1_ - x0_) + size_t(x - x0_)) * by_.size();
    }

    void find(int x, int y) {
        const kernel::Planes& planes = p_.planes;
        const bool here = planes.row(p_.samples(), y)[x] > 0;
        const VF zero = hn::Zero(f), k2 = hn::Set(f, by_.k_color * by_.k_color),
                 third = hn::Set(f, 1.0f / 3);
        VF mine[3], noise[3];
        for (size_t c = 0; c < 3; ++c) {
            mine[c] = hn::Set(f, planes.row(p_.color(c), y)[x]);
            noise[c] = hn::Set(f, planes.row(p_.color_noise(c), y)[x]);
        }
        for (int dy = -by_.radius; dy <= by_.radius; ++dy) {
            float* to = &scratch_.distances[at(x, y) + size_t(dy + by_.radius) * by_.pitch()];
            float* known = &scratch_.known[at(x, y) + size_t(dy + by_.radius) * by_.pitch()];
            if (!here || y + dy < 0 || y + dy >= planes.height) {
                std::fill_n(to, by_.pitch(), 0.0f);
                std::fill_n(known, by_.pitch(), 0.0f);
                continue;
            }
            const int from = x - by_.radius;
            for (size_t i = 0; i < by_.pitch(); i += lanes) {
                VF sum = zero;
                for (size_t c = 0; c < 3; ++c) {
                    const VF d =
                        hn::Sub(hn::LoadU(f, planes.row(p_.color(c), y + dy) + from + i), mine[c]);
                    const VF other = hn::LoadU(f, planes.row(p_.color_noise(c), y + dy) + from + i);
                    const VF less =
                        hn::MulAdd(d, d, hn::Neg(hn::Add(noise[c], hn::Min(noise[c], other))));
                    sum = hn::Add(sum, hn::Div(less, hn::MulAdd(k2, hn::Add(noise[c], other),
                                                                hn::Set(f, 1e-10f))));
                }
                const auto there =
                    hn::Gt(hn::LoadU(f, planes.row(p_.samples(), y + dy) + from + i), zero);
                hn::StoreU(hn::IfThenElseZero(there, hn::Mul(sum, third)), f, to + i);
                hn::StoreU(hn::IfThenElseZero(there, hn::Set(f, 1.0f)), f, known + i);
            }
        }
    }

    const PixelStatistics& p_;
    const PixelLikeness& by_;
    PixelScratch& scratch_;
    int x0_, y0_, x1_, y1_;
};

// Distances of features from (x, y) to the pixels from `from` on of row y + dy.
HWY_INLINE VF feature_distances(const PixelStatistics& p, const PixelLikeness& by,
                                const PixelScratch& scratch, int x, int y, int from, int row) {
    const VF zero = hn::Zero(f), k2 = hn::Set(f, by.k_features * by.k_features);
    VF sum = zero;
    for (size_t g = 0; g < p.groups.size(); ++g) {
        if (!(scratch.beta[g] > 0)) continue;
        VF square = zero;
        for (size_t k = p.groups[g].begin; k < p.groups[g].end; ++k) {
            const VF d = hn::Sub(hn::LoadU(f, p.planes.row(p.mean(k), row) + from),
                                 hn::Set(f, p.planes.row(p.mean(k), y)[x]));
            square = hn::MulAdd(d, d, square);
        }
        const VF mine = hn::Set(f, p.planes.row(p.noise(g), y)[x]),
                 other = hn::LoadU(f, p.planes.row(p.noise(g), row) + from);
        const VF less = hn::Sub(square, hn::Add(mine, hn::Min(mine, other)));
        const VF pass = hn::MulAdd(k2, hn::Add(mine, other), hn::Set(f, scratch.feature_scale[g]));
        sum = hn::MulAdd(hn::Set(f, scratch.beta[g]), hn::Max(zero, hn::Div(less, pass)), sum);
    }
    return sum;
}

}  // namespace

void weigh_pixels(const SampleVectors& vectors, PixelBlock block, const Weights& weights,
                  const PixelLikeness& by, PixelScratch& scratch, std::vector<float>& out) {
    const PixelStatistics& p = vectors.pixels;
    const auto own = size_t(block.x1 - block.x0) * size_t(block.y1 - block.y0);
    out.resize(own * by.size());
    scratch.nearness.assign(by.size(), 0.0f);
    for (int dy = -by.radius; dy <= by.radius; ++dy)
        for (int dx = -by.radius; dx <= by.radius; ++dx)
            scratch.nearness[size_t(dy + by.radius) * by.pitch() + size_t(dx + by.radius)] =
                std::exp(-float(dx * dx + dy * dy) / (2 * by.sigma * by.sigma));
    // One weight a feature, that of its components' mean; one of all colours.
    scratch.beta.assign(p.groups.size(), 0.0f);
    scratch.feature_scale.resize(p.groups.size());
    for (size_t g = 0; g < p.groups.size(); ++g) {
        for (size_t k = p.groups[g].begin; k < p.groups[g].end; ++k)
            scratch.beta[g] += weights.of_row[k];
        scratch.beta[g] /= float(p.groups[g].end - p.groups[g].begin);
    }
    const size_t colors = vectors.components.size();
    const VF alpha = hn::Set(
        f, (weights.of_row[colors] + weights.of_row[colors + 1] + weights.of_row[colors + 2]) / 3);

    const ColorDistances color(p, block, by, scratch);
    float* to = out.data();
    for (int y = block.y0; y < block.y1; ++y)
        for (int x = block.x0; x < block.x1; ++x, to += by.size()) {
            for (size_t g = 0; g < p.groups.size(); ++g)
                scratch.feature_scale[g] =
                    std::max({1e-30f, 2 * by.least * by.least * p.groups[g].deviation2,
                              2 * by.slope * by.slope * p.planes.row(p.slope(g), y)[x]});
            for (int dy = -by.radius; dy <= by.radius; ++dy) {
                const size_t row = size_t(dy + by.radius) * by.pitch();
                if (y + dy < 0 || y + dy >= p.planes.height) {
                    std::fill_n(to + row, by.pitch(), 0.0f);
                    continue;
                }
                for (size_t i = 0; i < by.pitch(); i += lanes) {
                    const int from = x - by.radius + int(i);
                    const VF distance =
                        hn::MulAdd(alpha, color.mean(x, y, row + i),
                                   feature_distances(p, by, scratch, x, y, from, y + dy));
                    const VF w = hn::Mul(hn::LoadU(f, &scratch.nearness[row + i]),
                                         exp_of_minus(hn::Min(distance, hn::Set(f, 80.0f))));
                    const auto there =
                        hn::Gt(hn::LoadU(f, p.planes.row(p.samples(), y + dy) + from), hn::Zero(f));
                    hn::StoreU(hn::IfThenElseZero(there, w), f, to + row + i);
                }
            }
        }
}

}  // namespace weft::rpf::WEFT_ISA
