#include "light-field/local_radius.h"

#include <algorithm>
#include <cmath>

#include "light-field/build_hierarchy_kernel.h"

namespace weft::light_field {
namespace {

// Numbers of samples in rectangles of pixels, by a table of sums.
class Counts {
  public:
    explicit Counts(const Samples& samples)
        : width(samples.width),
          height(samples.height),
          sums(size_t(width + 1) * size_t(height + 1), 0) {
        for (int y = 0; y < height; ++y) {
            std::uint32_t row = 0;
            for (int x = 0; x < width; ++x) {
                const Samples::Range range =
                    samples.of_pixel(size_t(y) * size_t(width) + size_t(x));
                row += std::uint32_t(range.end - range.begin);
                sums[at(x + 1, y + 1)] = sums[at(x + 1, y)] + row;
            }
        }
    }
    // Samples a pixel, of those within `reach` of this one.
    double density(int x, int y, int reach) const {
        const int x0 = std::max(x - reach, 0), x1 = std::min(x + reach + 1, width);
        const int y0 = std::max(y - reach, 0), y1 = std::min(y + reach + 1, height);
        const std::uint32_t n =
            sums[at(x1, y1)] - sums[at(x0, y1)] - sums[at(x1, y0)] + sums[at(x0, y0)];
        return double(n) / (double(x1 - x0) * double(y1 - y0));
    }

  private:
    size_t at(int x, int y) const { return size_t(y) * size_t(width + 1) + size_t(x); }
    int width, height;
    std::vector<std::uint32_t> sums;
};

float radius_of_pixel(const Counts& counts, int x, int y) {
    constexpr float per_radius = 0.886226925f;  // half the side of a square as large as the disk
    for (int reach = 0;; ++reach) {
        const float radius = dispersion_radius(counts.density(x, y, reach));
        if (per_radius * radius <= float(reach) + 0.5f) return radius;  // R is below 5: it ends
    }
}

}  // namespace

std::vector<float> local_radii(const Samples& samples, double scale, Context& ctx) {
    if (samples.spp > 0 || samples.first.size() != samples.pixels() + 1 || samples.size() == 0)
        return {};
    const Counts counts(samples);
    std::vector<float> radii(samples.pixels());
    ctx.parallel_rows(samples.height, [&](Rows rows) {
        for (int y = rows.begin; y < rows.end; ++y)
            for (int x = 0; x < samples.width; ++x)
                radii[size_t(y) * size_t(samples.width) + size_t(x)] =
                    float(scale) * radius_of_pixel(counts, x, y);
    });
    const auto [least, most] = std::minmax_element(radii.begin(), radii.end());
    if (*most <= 1.1f * *least) return {};
    return radii;
}

float largest_radius(const Hierarchy& h, const Locations& at) {
    if (at.ratio.empty()) return h.largest_radius(at.x0, at.y0, at.x1, at.y1);
    const size_t n = at.size();
    return n == 0 ? h.radius
                  : h.radius * *std::max_element(at.ratio.begin(), at.ratio.begin() + std::ptrdiff_t(n));
}

void narrow(float scale, const Locations& at, Candidates& c) {
    const Hierarchy& h = *c.hierarchy;
    c.ratio.clear();
    if (h.radii.empty() && at.ratio.empty()) return;
    c.ratio.resize(c.size());
    std::uint32_t to = 0, begin = 0;
    for (size_t l = 0; l < c.size(); ++l) {
        const float own =
            at.ratio.empty() ? h.radius_at(c.x[l], c.y[l]) : h.radius * at.ratio[l];
        const float radius = scale * own, limit = radius * radius;
        c.ratio[l] = own / h.radius;
        const std::uint32_t end = c.offset[l + 1];
        for (std::uint32_t i = begin; i < end; ++i) {
            const float x = c.dx[i], y = c.dy[i];
            const std::uint32_t sample = c.sample[i];
            c.dx[to] = x;
            c.dy[to] = y;
            c.sample[to] = sample;
            to += x * x + y * y < limit;  // no branch: it could not be foreseen
        }
        begin = end;
        c.offset[l + 1] = to;
    }
}

}  // namespace weft::light_field
