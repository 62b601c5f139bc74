#include "adaptive/sheared_filter_kernel.h"

#include <bit>

#include "adaptive/sheared_weights.h"
#include "samples/random.h"

namespace weft::adaptive {

namespace {

constexpr float narrowest_move = 1e-3f;  // px: less is none
constexpr int most_times = 16;           // at which a lens is looked through

bool finite(const float* color) {
    return std::isfinite(color[0]) && std::isfinite(color[1]) && std::isfinite(color[2]);
}

}  // namespace

ShearedFilter::ShearedFilter(const Samples& samples, const Image* slopes,
                             const ShearedSettings& settings)
    : samples_(samples),
      paths_(samples),
      settings_(settings),
      cuts_(paths_.lens()),
      round_(paths_.lens().blades < 3 && !settings.pieces),
      shutter_(shutter_of(samples.meta)),
      rgb_(samples.rgb()),
      weight_(samples.values("weight")) {
    if (slopes) slopes_.emplace(*slopes, "sheared-filter");
    for (size_t pixel = 0; pixel < samples.pixels(); ++pixel) {
        const float px = float(pixel % size_t(samples.width)),
                    py = float(pixel / size_t(samples.width));
        const auto range = samples.of_pixel(pixel);
        for (size_t i = range.begin; i < range.end; ++i)
            overhang_ = std::max({overhang_, px - paths_.x(i), paths_.x(i) - px - 1,
                                  py - paths_.y(i), paths_.y(i) - py - 1});
    }
    overhang_ = std::min(overhang_, 1.0f);
    if (shutter_.constant()) return;
    const auto mean_of = [&](const auto& of) {
        constexpr int steps = 256;
        double sum = 0;
        for (int k = 0; k < steps; ++k) {
            const double t = (k + 0.5) / steps;
            sum += of(t) * double(shutter_.openness(float(t))) / steps;
        }
        return sum;
    };
    mean_time_ = mean_of([](double t) { return t; });
    time_second_ = mean_of([&](double t) { return std::pow(t - mean_time_, 2); });
    time_third_ = mean_of([&](double t) { return std::pow(t - mean_time_, 3); });
}

ShearedFilter::Filter ShearedFilter::filter_of(const PixelSlopes& s, int x, int y) const {
    constexpr double longest = 64;  // px a cycle: beyond that lower resolution would do
    Filter out;
    out.x = float(x) + 0.5f, out.y = float(y) + 0.5f;
    out.pixel = std::uint32_t(y) * std::uint32_t(samples_.width) + std::uint32_t(x);
    const auto widened = [&](double band) {
        const double period = std::min(1 / band, longest), pixel = 1 / pixel_band;
        const double sigma =
            double(settings_.across) * std::sqrt(std::max(period * period - pixel * pixel, 0.0));
        return 12 * sigma * sigma;
    };
    const double along = widened(s.band()), aside = widened(s.band_across());
    out.half_x = float(0.5 * std::sqrt(1 + along * s.nx * s.nx + aside * s.ny * s.ny));
    out.half_y = float(0.5 * std::sqrt(1 + along * s.ny * s.ny + aside * s.nx * s.nx));
    // Four windows are as good as endless ones.
    const auto sigma = [&](double residual, double window) {
        const double found = residual > 0 ? double(settings_.along) / residual : INFINITY;
        return found < 4 * window ? float(found) : INFINITY;
    };
    if (s.motion && paths_.moving()) {
        out.vx = float(s.vx()), out.vy = float(s.vy());
        out.sigma_t = sigma(s.residual(), 1);
        out.reach_t = std::min(1.0f, settings_.cap * out.sigma_t);
        out.moves = std::hypot(out.vx, out.vy) > narrowest_move || out.sigma_t < INFINITY;
    }
    if (s.lens && paths_.has_lens()) {
        out.coc_x = float(s.coc()) * paths_.lens().aspect, out.coc_y = float(s.coc());
        out.sigma_lens = sigma(s.lens_residual(), 2);
        out.reach_lens = std::min(2.0f, settings_.cap * out.sigma_lens);
        out.blurs = std::abs(out.coc_y) > narrowest_move || out.sigma_lens < INFINITY;
    }
    return out;
}

float ShearedFilter::time_weight(const Filter& f, float dx, float dy, float t) const {
    const Interval x = inside_box(dx, f.vx, f.half_x, t, 0, 1);
    if (x.empty()) return 0;
    const Interval in = inside_box(dy, f.vy, f.half_y, t, x.a, x.b);
    if (in.empty()) return 0;
    const float w = gaussian_over(in, t, f.sigma_t);
    return shutter_.constant() ? w : w * shutter_.openness((in.a + in.b) / 2);
}

// u, v on the unit disc, aspect taken out.
float ShearedFilter::lens_weight(const Filter& f, float dx, float dy, float u, float v) const {
    const Interval x = inside_box(dx, f.coc_x, f.half_x, u, -1, 1);
    if (x.empty()) return 0;
    const Interval y = inside_box(dy, f.coc_y, f.half_y, v, -1, 1);
    if (y.empty()) return 0;
    if (!round_) return pieces_weight(f, x, y, u, v);
    const float share = share_on_disc(x, y);
    return share > 0 ? share * gaussian_over(x, u, f.sigma_lens) * gaussian_over(y, v, f.sigma_lens)
                     : 0.0f;
}

float ShearedFilter::pieces_weight(const Filter& f, Interval x, Interval y, float u,
                                   float v) const {
    const LensPieces& in = pieces(f);
    const GaussianMass along(v, f.sigma_lens);
    const float whole = along.in(y);
    float sum = 0;
    in.each_column(x, {u, f.sigma_lens}, [&](size_t k, float across) {
        const Interval part = y.in(in.v[k]);
        // Most often all of y lies in the column.
        if (!part.empty())
            sum += across * (part.a == y.a && part.b == y.b ? whole : along.in(part));
    });
    return sum;
}

float ShearedFilter::weight(const Filter& f, size_t i) const {
    const float dx = paths_.x(i) - f.x, dy = paths_.y(i) - f.y;
    const Lens& lens = paths_.lens();
    if (!f.blurs) return time_weight(f, dx, dy, paths_.t(i));
    const auto on = paths_.uv(i);
    const float u = on[0] / lens.aspect, v = on[1], t = paths_.t(i);
    if (!f.moves) return lens_weight(f, dx, dy, u, v);

    // Lens and shutter together have no closed form: the lens is looked through at a few times,
    // shifted from pixel to pixel and sample to sample, so that they leave noise, not steps.
    const std::uint64_t key = mix(std::uint64_t(f.pixel) << 32 | std::uint64_t(i));
    const auto falls = [](float way, float sigma) {
        return sigma < INFINITY ? std::exp(-way * way / (2 * sigma * sigma)) : 1.0f;
    };
    float sum = 0;
    const int times = std::clamp(int(std::ceil(std::hypot(f.vx, f.vy) * 2)), 4, most_times);
    const float shift = unit_float(key);
    for (int k = 0; k < times; ++k) {
        const float at = (float(k) + shift) / float(times), way = at - t;
        if (std::abs(way) > f.reach_t) continue;
        const float w = lens_weight(f, dx + f.vx * way, dy + f.vy * way, u, v);
        if (w > 0)
            sum += w * falls(way, f.sigma_t) * (shutter_.constant() ? 1 : shutter_.openness(at));
    }
    return sum / float(times);
}

ShearedFilter::Pixel ShearedFilter::own_mean(int x, int y) const {
    Sums sums;
    const auto range = samples_.of_pixel(size_t(y) * size_t(samples_.width) + size_t(x));
    for (size_t i = range.begin; i < range.end; ++i)
        if (finite(&rgb_[3 * i]))
            sums.add(weight_.empty() ? 1 : double(weight_[i]), &rgb_[3 * i], 0, 0);
    Pixel out = sums.mean();
    out.own_mean = true;
    return out;
}

bool ShearedFilter::keeps_own(const PixelSlopes& s, const Pixel& own) const {
    const auto too_wide = [&](double lo, double hi) {
        return lo <= 0 && hi >= 0 && hi - lo > double(settings_.wide);
    };
    return settings_.fallback && own.effective > 0 &&
           (!s.known || too_wide(s.lo, s.hi) || too_wide(s.lens_lo, s.lens_hi));
}

ShearedFilter::Pixel ShearedFilter::better(const Pixel& found, const Pixel& own) const {
    return settings_.fallback && found.effective < settings_.gain * own.effective ? own : found;
}

ShearedFilter::Pixel ShearedFilter::gathered(const Filter& f) const {
    if (f.moves && !f.blurs) return gathered_along(f);
    Sums sums;
    gather(f, [&](size_t i, double w) {
        const auto from = from_middle(f, i);
        sums.add(w, &rgb_[3 * i], from[0], from[1]);
    });
    return sums.fitted();
}

ShearedFilter::Pixel ShearedFilter::gathered_along(const Filter& f) const {
    const double vx = double(f.vx), vy = double(f.vy), speed = std::hypot(vx, vy);
    const double nx = speed > 0 ? vx / speed : 1, ny = speed > 0 ? vy / speed : 0;
    // A box's variance is a third of its half width's square.
    const double box =
        (std::pow(nx * double(f.half_x), 2) + std::pow(ny * double(f.half_y), 2)) / 3;
    PathSums sums(box + speed * speed * time_second_, -std::pow(speed, 3) * time_third_);
    gather(f, [&](size_t i, double w) {
        const auto from = from_middle(f, i);
        sums.add(w, &rgb_[3 * i], from[0] * nx + from[1] * ny, from[1] * nx - from[0] * ny);
    });
    Pixel out;
    if (!(sums.effective() > 0)) return out;
    const auto mean = sums.fitted();
    std::copy(mean.begin(), mean.end(), out.rgb);
    out.effective = float(sums.effective());
    return out;
}

ShearedFilter::Pixel ShearedFilter::filtered(int x, int y) const {
    const PixelSlopes s = (*slopes_)(x, y);
    const Pixel own = own_mean(x, y);
    if (keeps_own(s, own)) return own;
    Filter f = filter_of(s, x, y);
    for (int tries = 0; tries < 4; ++tries) {
        const Pixel found = gathered(f);
        if (found.effective > 0) return better(found, own);
        f.half_x *= 2, f.half_y *= 2;
    }
    return own;
}

}  // namespace weft::adaptive
