#include "light-field/view_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace weft::light_field {
namespace {

constexpr size_t axes = 3;  // u, v, t

// Sums over candidates.
struct Moments {
    double count = 0;
    std::array<double, axes> p{};                     // of p, a place
    std::array<std::array<double, axes>, axes> pp{};  // of p p'
    std::array<double, 5> c{};                        // of c: r g b alpha luminance
    std::array<std::array<double, 5>, axes> pc{};     // of p c
    double yy = 0;                                    // of luminance^2

    void add(const std::array<double, axes>& place, const std::array<double, 5>& color) {
        ++count;
        for (size_t a = 0; a < axes; ++a) {
            p[a] += place[a];
            for (size_t b = 0; b < axes; ++b) pp[a][b] += place[a] * place[b];
            for (size_t k = 0; k < 5; ++k) pc[a][k] += place[a] * color[k];
        }
        for (size_t k = 0; k < 5; ++k) c[k] += color[k];
        yy += color[4] * color[4];
    }
};

// The planes' slopes of all five numbers over (u, v, t), and the F of luminance.
struct Fit {
    std::array<std::array<double, 5>, axes> slope{};
    double f = 0;
};

// Gaussian elimination without pivots: the matrix is a covariance. An axis that does not vary by
// itself is left out.
Fit fit(const Moments& m) {
    Fit result;
    std::array<std::array<double, axes>, axes> cov;
    std::array<std::array<double, 5>, axes> with;
    for (size_t a = 0; a < axes; ++a) {
        for (size_t b = 0; b < axes; ++b) cov[a][b] = m.pp[a][b] - m.p[a] * m.p[b] / m.count;
        for (size_t k = 0; k < 5; ++k) with[a][k] = m.pc[a][k] - m.p[a] * m.c[k] / m.count;
    }
    const auto before = with;
    std::array<bool, axes> used{};
    double used_axes = 0;
    for (size_t a = 0; a < axes; ++a) {
        used[a] =
            cov[a][a] > 1e-4 * m.count;  // of lens and shutter, whose variances are 1/4 and 1/12
        if (!used[a]) continue;
        ++used_axes;
        for (size_t b = 0; b < axes; ++b) {
            if (b == a) continue;
            const double factor = cov[b][a] / cov[a][a];
            for (size_t k = 0; k < axes; ++k) cov[b][k] -= factor * cov[a][k];
            for (size_t k = 0; k < 5; ++k) with[b][k] -= factor * with[a][k];
        }
    }
    double explained = 0;
    for (size_t a = 0; a < axes; ++a) {
        if (!used[a]) continue;
        for (size_t k = 0; k < 5; ++k) result.slope[a][k] = with[a][k] / cov[a][a];
        explained += result.slope[a][4] * before[a][4];
    }
    const double freedom = m.count - 1 - used_axes;
    const double left = m.yy - m.c[4] * m.c[4] / m.count - explained;
    if (used_axes > 0 && freedom >= 1 && explained > 0)
        result.f = left > 1e-12 * m.yy ? explained / used_axes * freedom / left : 1e12;
    return result;
}

// What location l sees of surfaces [first, last]; false where there is nothing.
bool read(const Candidates& c, const Surfaces& s, size_t l, std::uint16_t first, std::uint16_t last,
          const Tent& tent, double test, float* to) {
    const Hierarchy& h = *c.hierarchy;
    const auto uv = h.uv.view(), t = h.t.view();
    const float radius = tent.radius * c.ratio_of(l);
    Moments all;        // every candidate counts alike: what the plane is fitted to
    double weight = 0;  // of those in the tent, whose mean is taken
    std::array<double, axes> place_mean{};  // where they were seen from, on average
    std::array<double, 4> mean{};
    std::array<float, 4> low, high;
    low.fill(3e38f), high.fill(-3e38f);
    float nearest = 3e38f;
    size_t nearest_sample = 0;
    for (size_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
        if (s.surface[i] < first || s.surface[i] > last) continue;
        const float d2 = c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i];
        if (d2 < nearest) nearest = d2, nearest_sample = c.sample[i];
        const size_t from = h.order[c.sample[i]];
        const float* rgba = &h.rgba[4 * size_t(c.sample[i])];
        std::array<double, axes> place{};
        if (!uv.empty())
            place[0] = double(uv[2 * from]) - double(c.u_of(l)),
            place[1] = double(uv[2 * from + 1]) - double(c.v_of(l));
        if (!t.empty()) place[2] = double(t[from]) - double(c.t_of(l));
        all.add(place, {double(rgba[0]), double(rgba[1]), double(rgba[2]), double(rgba[3]),
                        (double(rgba[0]) + double(rgba[1]) + double(rgba[2])) / 3});
        for (size_t k = 0; k < 4; ++k)
            low[k] = std::min(low[k], rgba[k]), high[k] = std::max(high[k], rgba[k]);
        const double w = std::pow(std::max(0.0, 1 - std::sqrt(double(d2)) / double(radius)),
                                  double(tent.exponent));
        weight += w;
        for (size_t a = 0; a < axes; ++a) place_mean[a] += w * place[a];
        for (size_t k = 0; k < 4; ++k) mean[k] += w * double(rgba[k]);
    }
    if (all.count == 0) return false;
    if (!(weight > 0)) {
        std::copy_n(&h.rgba[4 * nearest_sample], 4, to);
        return true;
    }
    const Fit plane = fit(all);
    const double share = plane.f > test ? 1 - test / plane.f : 0;
    for (size_t k = 0; k < 4; ++k) {
        double value = mean[k] / weight;
        for (size_t a = 0; a < axes; ++a)
            value -= share * plane.slope[a][k] * place_mean[a] / weight;
        const float beyond = 0.5f * (high[k] - low[k]);
        to[k] =
            std::clamp(float(value), low[k] < 0 ? low[k] - beyond : std::max(low[k] - beyond, 0.0f),
                       high[k] + beyond);
    }
    return true;
}

}  // namespace

void filter_by_view(const Candidates& c, const Surfaces& s, const Visibility& visibility,
                    const Tent& tent, float test, Colors& out) {
    out.color_space = &c.hierarchy->color_space;
    out.rgba.assign(4 * c.size(), 0);
    out.valid.assign(c.size(), 0);
    size_t part = 0;
    for (size_t l = 0; l < c.size(); ++l) {
        if (visibility.decision[l] == Decision::undecided) continue;
        visibility.each_seen(l, part, [&](std::uint16_t first, std::uint16_t last, float share) {
            float seen[4];
            if (!read(c, s, l, first, last, tent, double(test), seen)) return;
            for (size_t k = 0; k < 4; ++k) out.rgba[4 * l + k] += share * seen[k];
            out.valid[l] = 1;
        });
    }
}

}  // namespace weft::light_field
