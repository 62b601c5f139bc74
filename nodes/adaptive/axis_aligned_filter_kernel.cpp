#include "adaptive/axis_aligned_filter_kernel.h"

#include <algorithm>
#include <cmath>

namespace weft::kernel {

GuardedWeights::GuardedWeights(const FilterWidths& widths, const SurfaceGuard& guard)
    : widths_(widths),
      guard_(guard),
      least_cosine_(std::cos(guard.normal_angle * 3.14159265f / 180)) {
    if (!guard.features) return;
    normal_ = guard.features->find("normal.x");
    position_ = guard.features->find("position.x");
    z_ = guard.features->find("z");
    id_ = guard.features->find("id");
}

float GuardedWeights::radius(int x, int y) const {
    const float* w = widths_.image->at(x, y);
    const float px = widths_.radius >= 0 ? w[widths_.radius] : w[widths_.beta];
    return std::min(px, float(widths_.reach));
}

float GuardedWeights::weight(float distance, float beta) const {
    // On an even grid the last pixels may lie at d = 1 sharp: rounding must not take one side only.
    constexpr float end = 1 - 1e-4f;
    const float d = distance / beta;
    return d < end ? std::exp(-3 * d * d) : 0.0f;
}

bool GuardedWeights::alike(int x, int y, int i, int j) const {
    const float a = widths_.image->at(x, y)[widths_.beta],
                b = widths_.image->at(i, j)[widths_.beta];
    // A pixel that nothing blurs is known without a filter, whatever its neighbour's width.
    if (b > 0 && (b > guard_.width_ratio * a || a > guard_.width_ratio * b)) return false;
    if (!guard_.features) return true;
    const float *f = guard_.features->at(x, y), *g = guard_.features->at(i, j);
    if (id_ >= 0 && f[id_] != g[id_]) return false;
    if (z_ >= 0 && f[z_] != g[z_]) {
        const float nearer = std::min(f[z_], g[z_]);
        if (!(std::abs(f[z_] - g[z_]) <= guard_.depth * nearer)) return false;
    }
    if (normal_ < 0) return true;
    const float *n = f + normal_, *m = g + normal_;
    const float nn = n[0] * n[0] + n[1] * n[1] + n[2] * n[2],
                mm = m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
    if (nn > 0 && mm > 0 &&
        n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < least_cosine_ * std::sqrt(nn * mm))
        return false;
    if (position_ < 0) return true;
    const float *p = f + position_, *q = g + position_;
    const float off = n[0] * (q[0] - p[0]) + n[1] * (q[1] - p[1]) + n[2] * (q[2] - p[2]);
    return std::abs(off) <= guard_.depth * std::sqrt(nn > 0 ? nn : 1.0f) * p[2];
}

float GuardedWeights::operator()(int x, int y, int i, int j) const {
    const float *a = widths_.image->at(x, y), *b = widths_.image->at(i, j);
    float distance;
    if (widths_.x >= 0)
        distance = std::hypot(a[widths_.x] - b[widths_.x], a[widths_.y] - b[widths_.y]);
    else
        distance = std::hypot(float(x - i), float(y - j));
    const float w = weight(distance, a[widths_.beta]);
    return w > 0 && alike(x, y, i, j) ? w : 0.0f;
}

namespace {

// Means along rows (dx 1) or columns (dy 1).
void pass(const Image& from, const GuardedWeights& weights, const FilterWidths& widths, int dx,
          int dy, Image& to, Context& ctx) {
    const auto channels = size_t(from.channels());
    ctx.parallel_rows(from.height(), [&](Rows rows) {
        std::vector<float> change(channels);
        for (int y = rows.begin; y < rows.end; ++y)
            for (int x = 0; x < from.width(); ++x) {
                const float* own = from.at(x, y);
                float* mean = to.at(x, y);
                std::copy_n(own, channels, mean);
                if (!(widths.image->at(x, y)[widths.beta] > 0)) continue;
                const int reach = int(std::ceil(weights.radius(x, y)));
                float total = 1;
                std::fill(change.begin(), change.end(), 0.0f);
                // Outwards, both sides in turn: what is even stays even.
                for (int k = 1; k <= reach; ++k)
                    for (const int side : {-k, k}) {
                        const int i = x + side * dx, j = y + side * dy;
                        if (i < 0 || i >= from.width() || j < 0 || j >= from.height()) continue;
                        const float w = weights(x, y, i, j);
                        if (!(w > 0)) continue;
                        total += w;
                        const float* there = from.at(i, j);
                        for (size_t c = 0; c < channels; ++c) change[c] += w * (there[c] - own[c]);
                    }
                for (size_t c = 0; c < channels; ++c) mean[c] += change[c] / total;
            }
    });
}

}  // namespace

Image filter_all_round(const Image& image, const FilterWidths& widths, const SurfaceGuard& guard,
                       Context& ctx) {
    const GuardedWeights weights(widths, guard);
    Image across = Image::like(image), out = Image::like(image);
    pass(image, weights, widths, 1, 0, across, ctx);
    pass(across, weights, widths, 0, 1, out, ctx);
    return out;
}

Image filter_along(const Image& image, const FilterWidths& widths, const SurfaceGuard& guard,
                   Context& ctx) {
    const GuardedWeights weights(widths, guard);
    const auto channels = size_t(image.channels());
    Image out = Image::like(image);
    ctx.parallel_rows(image.height(), [&](Rows rows) {
        std::vector<float> change(channels);
        for (int y = rows.begin; y < rows.end; ++y)
            for (int x = 0; x < image.width(); ++x) {
                const float *own = image.at(x, y), *w = widths.image->at(x, y);
                float* mean = out.at(x, y);
                std::copy_n(own, channels, mean);
                const float beta = w[widths.beta], nx = w[widths.nx], ny = w[widths.ny];
                const float longer = std::max(std::abs(nx), std::abs(ny));
                if (!(beta > 0) || !(longer > 0)) continue;
                const bool steep = std::abs(ny) > std::abs(nx);
                const float slope = steep ? nx / ny : ny / nx;
                const int reach = int(std::ceil(weights.radius(x, y) * longer));
                float total = 1;
                std::fill(change.begin(), change.end(), 0.0f);
                for (int k = 1; k <= reach; ++k)
                    for (const int side : {-k, k}) {
                        const float across = float(side) * slope, below = std::floor(across);
                        const float along = weights.weight(float(k) / longer, beta);
                        if (!(along > 0)) continue;
                        for (const int next : {0, 1}) {
                            const float share = next ? across - below : 1 - (across - below);
                            const int aside = int(below) + next;
                            const int i = x + (steep ? aside : side),
                                      j = y + (steep ? side : aside);
                            if (!(share > 0) || i < 0 || i >= image.width() || j < 0 ||
                                j >= image.height() || !weights.alike(x, y, i, j))
                                continue;
                            total += along * share;
                            const float* there = image.at(i, j);
                            for (size_t c = 0; c < channels; ++c)
                                change[c] += along * share * (there[c] - own[c]);
                        }
                    }
                for (size_t c = 0; c < channels; ++c) mean[c] += change[c] / total;
            }
    });
    return out;
}

}  // namespace weft::kernel
