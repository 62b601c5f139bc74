#include "rpf/pixel_statistics.h"

#include <algorithm>
#include <cmath>

namespace weft::rpf {
namespace {

constexpr int rows_at_once = 8;

// Means of a pixel's whole samples and the variance of a single one, by differences to the first:
// sums keep their digits.
class PixelSums {
  public:
    explicit PixelSums(const SampleVectors& v) : v_(v), values_(v.stride() - v.pixels.first) {
        sum_.resize(values_);
        square_.resize(values_);
    }

    size_t add(size_t pixel) {
        std::fill(sum_.begin(), sum_.end(), 0.0f);
        std::fill(square_.begin(), square_.end(), 0.0f);
        n_ = 0;
        const auto [begin, end] = v_.samples.of_pixel(pixel);
        for (size_t j = begin; j < end; ++j) {
            if (!v_.is_whole(j)) continue;
            if (n_++ == 0) base_ = j;
            const float *a = v_.of(j) + v_.pixels.first, *b = v_.of(base_) + v_.pixels.first;
            for (size_t k = 0; k < values_; ++k) add(k, a[k] - b[k]);
        }
        return n_;
    }
    // Of value k: feature components, then colours.
    float mean(size_t k) const { return v_.of(base_)[v_.pixels.first + k] + sum_[k] / float(n_); }
    float variance(size_t k) const {
        return n_ < 2 ? 0.0f
                      : std::max(0.0f, square_[k] - sum_[k] * sum_[k] / float(n_)) / float(n_ - 1);
    }

  private:
    void add(size_t k, float x) {
        sum_[k] += x;
        square_[k] += x * x;
    }
    const SampleVectors& v_;
    size_t values_, n_ = 0, base_ = 0;
    std::vector<float> sum_, square_;
};

// The variance of a mean: that of the pixel's samples, half by themselves and half by those of the
// pixels around, whose estimate is steadier, over their number. `to` and `from` are planes; from:
// variances of single samples.
void find_noise(kernel::Planes& planes, int to, const kernel::Planes& from, int plane, int samples,
                double spp, int y) {
    const int width = planes.width, height = planes.height;
    for (int x = 0; x < width; ++x) {
        const float n = planes.row(samples, y)[x];
        if (!(n > 0)) continue;
        double sum = 0, weight = 0;
        for (int j = std::max(0, y - 1); j <= std::min(y + 1, height - 1); ++j)
            for (int i = std::max(0, x - 1); i <= std::min(x + 1, width - 1); ++i) {
                const double freedom = double(planes.row(samples, j)[i]) * spp - 1;
                if (freedom < 0.5) continue;
                const double w = (i == x && j == y ? 8 : 1) * freedom;
                sum += w * double(from.row(plane, j)[i]);
                weight += w;
            }
        if (weight > 0) planes.row(to, y)[x] = float(sum / weight / (double(n) * spp));
    }
}

// Single samples everywhere: their noise is how much their pixel differs from those around.
void find_noise_of_single(kernel::Planes& planes, std::span<const int> means, int to, int samples,
                          int y) {
    for (int x = 0; x < planes.width; ++x) {
        double sum = 0, pairs = 0;
        for (int j = std::max(0, y - 1); j <= std::min(y + 1, planes.height - 1); ++j)
            for (int i = std::max(0, x - 1); i <= std::min(x + 1, planes.width - 1); ++i) {
                if ((i == x && j == y) || !(planes.row(samples, j)[i] > 0)) continue;
                for (const int m : means) {
                    const double d = double(planes.row(m, j)[i]) - double(planes.row(m, y)[x]);
                    sum += 0.5 * d * d;
                }
                pairs += 1;
            }
        planes.row(to, y)[x] = pairs > 0 ? float(sum / pairs) : 0.0f;
    }
}

// Squared change to the next pixel along both axes, each on the side where it is less (an edge is
// no slope), noise off.
void find_slope(PixelStatistics& p, size_t group, int y) {
    const auto [begin, end, deviation2] = p.groups[group];
    const int width = p.planes.width, height = p.planes.height;
    const auto change = [&](int x, int i, int j) {
        if (i < 0 || i >= width || j < 0 || j >= height || !(p.planes.row(p.samples(), j)[i] > 0))
            return -1.0f;
        float sum = -(p.planes.row(p.noise(group), y)[x] + p.planes.row(p.noise(group), j)[i]);
        for (size_t k = begin; k < end; ++k) {
            const float d = p.planes.row(p.mean(k), y)[x] - p.planes.row(p.mean(k), j)[i];
            sum += d * d;
        }
        return std::max(0.0f, sum);
    };
    const auto less = [](float a, float b) {
        return a < 0 ? std::max(b, 0.0f) : b < 0 ? a : std::min(a, b);
    };
    for (int x = 0; x < width; ++x)
        p.planes.row(p.slope(group), y)[x] = less(change(x, x - 1, y), change(x, x + 1, y)) +
                                             less(change(x, x, y - 1), change(x, x, y + 1));
}

float deviation2(const PixelStatistics& p, const PixelStatistics::Group& group) {
    double total = 0;
    for (size_t k = group.begin; k < group.end; ++k) {
        const double about = double(p.planes.row(p.mean(k), 0)[0]);
        double n = 0, sum = 0, square = 0;
        for (int y = 0; y < p.planes.height; ++y)
            for (int x = 0; x < p.planes.width; ++x) {
                if (!(p.planes.row(p.samples(), y)[x] > 0)) continue;
                const double d = double(p.planes.row(p.mean(k), y)[x]) - about;
                n += 1;
                sum += d;
                square += d * d;
            }
        if (n > 0) total += std::max(0.0, square - sum * sum / n) / n;
    }
    return float(total);
}

}  // namespace

void find_pixel_statistics(SampleVectors& v, Context& ctx) {
    PixelStatistics& p = v.pixels;
    const int width = v.samples.width, height = v.samples.height;
    p.groups.clear();
    for (size_t c = 0; c < v.channels.size(); ++c) {
        const auto [begin, end] = v.of_channel(c);
        if (v.components[begin].role == Role::feature) p.groups.push_back({begin, end, 0});
    }
    p.first = p.groups.empty() ? v.components.size() : p.groups.front().begin;
    const size_t features = v.components.size() - p.first, groups = p.groups.size();
    p.set_features(features);
    p.planes = kernel::Planes(width, height, p.samples() + 1, PixelStatistics::most_reach);
    if (width == 0 || height == 0) return;

    const double spp = std::max(v.samples.mean_spp(), 1e-6);
    kernel::Planes single(width, height, int(groups) + 3, 0);  // variances of single samples
    const bool pairs = ctx.reduce(
        size_t(height), size_t(rows_at_once), false,
        [&](size_t begin, size_t end) {
            PixelSums sums(v);
            bool found = false;
            for (size_t y = begin; y < end; ++y)
                for (size_t x = 0; x < size_t(width); ++x) {
                    const size_t n = sums.add(y * size_t(width) + x);
                    p.planes.row(p.samples(), int(y))[x] = float(double(n) / spp);
                    if (n == 0) continue;
                    found |= n > 1;
                    for (size_t k = 0; k < features + 3; ++k)
                        p.planes.row(int(k), int(y))[x] = sums.mean(k);
                    for (size_t g = 0; g < groups; ++g)
                        for (size_t k = p.groups[g].begin; k < p.groups[g].end; ++k)
                            single.row(int(g), int(y))[x] += sums.variance(k - p.first);
                    for (size_t c = 0; c < 3; ++c)
                        single.row(int(groups + c), int(y))[x] = sums.variance(features + c);
                }
            return found;
        },
        [](bool a, bool b) { return a || b; });
    ctx.parallel_rows(height, [&](Rows rows) {
        std::vector<int> means;
        for (int y = rows.begin; y < rows.end; ++y) {
            for (size_t g = 0; g < groups + 3; ++g) {
                const int to = g < groups ? p.noise(g) : p.color_noise(g - groups);
                if (pairs) {
                    find_noise(p.planes, to, single, int(g), p.samples(), spp, y);
                    continue;
                }
                means.clear();
                if (g >= groups) means.push_back(p.color(g - groups));
                for (size_t k = g < groups ? p.groups[g].begin : 0;
                     g < groups && k < p.groups[g].end; ++k)
                    means.push_back(p.mean(k));
                find_noise_of_single(p.planes, means, to, p.samples(), y);
            }
        }
    });
    ctx.parallel_rows(height, [&](Rows rows) {
        for (int y = rows.begin; y < rows.end; ++y)
            for (size_t g = 0; g < groups; ++g) find_slope(p, g, y);
    });
    for (PixelStatistics::Group& group : p.groups) group.deviation2 = deviation2(p, group);
}

}  // namespace weft::rpf
