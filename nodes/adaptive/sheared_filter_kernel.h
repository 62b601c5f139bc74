// The sheared filter of pictures: a pixel's value is the mean of all samples that its mean velocity
// and its mean circle of confusion carry into it, each weighted by how much of shutter and lens it
// stands for there.
//   across  the pixel's box, wider by a Gaussian of deviation `across` sqrt(1/W^2 - 1/W_p^2) px in
//           that what is left is a box of the same variance: so W = W_p is the plain pixel
//   along   a Gaussian of deviation `along` / B of shutter or lens; B = 0: any sample of the path
//           stands for all of it
//   middle  samples that happen to lie to one side of the filter's middle are carried there by the
//           slope of their own values (a regression): a ramp is exact, however few they are; where
//           all that widens the filter is motion, so is what curves along it (path_sums.h)
// Source: Egan et al. 2009, Sec. 4 and 5.  Departures: boxes and exact intervals of time instead of
// Gaussians, so that the static limit is the box filter; where slopes spread across the way of
// motion, sliding is cut shorter instead of the pixel made wider; a pixel whose filter has less
// than twice the samples, by their weights, that it has itself keeps its own mean, whose samples
// are better spread over it than those from elsewhere. Cost: one weight for each sample in the
// swept footprint of a pixel.
#pragma once
#include <optional>
#include <vector>

#include "adaptive/lens_pieces.h"
#include "adaptive/path_sums.h"
#include "adaptive/sample_paths.h"
#include "adaptive/slopes.h"
#include "samples/lens_shape.h"

namespace weft::adaptive {

struct ShearedSettings {
    float across = 0.08f, along = 0.2f, cap = 2.5f;
    float wide = 4;        // px: wider ranges about 0 are not filtered
    float gain = 2;        // times a pixel's own samples that are worth taking others for
    bool fallback = true;  // the pixel's own mean there, and where few samples would have a say
    bool pieces = false;   // a round lens, too, as the columns of lens_pieces.h
};

class ShearedFilter {
  public:
    // Keeps references. Without slopes there is no filtered().
    ShearedFilter(const Samples& samples, const Image* slopes, const ShearedSettings& settings);

    struct Pixel {
        double rgb[3] = {0, 0, 0};
        float effective = 0;    // samples, by their weights: (sum w)^2 / sum w^2
        bool own_mean = false;  // the pixel's own samples alone
    };
    // `own_mean` and effective 0: there are no samples near.
    Pixel filtered(int x, int y) const;
    Pixel own_mean(int x, int y) const;
    // Whether a pixel keeps its own mean, whatever samples there are around; and if not, when those
    // that were found are too few.
    bool keeps_own(const PixelSlopes& slopes, const Pixel& own) const;
    Pixel better(const Pixel& found, const Pixel& own) const;

    // Of a pixel: its box, the way that samples are slid, and how far.
    struct Filter {
        float x = 0, y = 0, half_x = 0.5f, half_y = 0.5f;
        float vx = 0, vy = 0, sigma_t = INFINITY, reach_t = 1;
        float coc_x = 0, coc_y = 0, sigma_lens = INFINITY, reach_lens = 2;
        bool moves = false, blurs = false;
        float coc() const { return std::max(std::abs(coc_x), std::abs(coc_y)); }
        std::uint32_t pixel = 0;
    };
    Filter filter_of(const PixelSlopes& slopes, int x, int y) const;
    // take(i, w) for all samples that may be slid into the pixel, with what they stand for there:
    // along a thick line through it, row by row.
    template <class Take>
    void gather(const Filter& filter, const Take& take) const;
    // Of a filter that does not move: the columns and the rows, first and last, that it reaches.
    std::array<int, 2> columns_of(const Filter& f) const {
        return pixels_between(f.x, f.x, pad_x(f), samples_.width);
    }
    std::array<int, 2> rows_of(const Filter& f) const {
        return pixels_between(f.y, f.y, pad_y(f), samples_.height);
    }
    const SamplePaths& paths() const { return paths_; }
    // Of a lens in pieces: those of a filter.
    const LensPieces& pieces(const Filter& f) const { return cuts_(f.coc()); }
    // Where a sample's path is, at the shutter's mean time, from the lens's centre, from the
    // middle of a filter.
    std::array<double, 2> from_middle(const Filter& f, size_t i) const {
        const auto on = paths_.uv(i);
        const double way = mean_time_ - double(paths_.t(i));
        return {double(paths_.x(i) - f.x - f.coc_y * on[0]) + double(f.vx) * way,
                double(paths_.y(i) - f.y - f.coc_y * on[1]) + double(f.vy) * way};
    }

    static constexpr float least_to_fit = 6;  // effective samples
    // Weighted samples of a pixel, and how they lie about its filter's middle.
    struct Sums {
        double weight = 0, squares = 0;
        double rgb[3] = {0, 0, 0};
        double px = 0, py = 0, pxx = 0, pxy = 0,
               pyy = 0;  // where they are from the filter's middle
        double rgb_x[3] = {0, 0, 0}, rgb_y[3] = {0, 0, 0};
        float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
        void add(double w, const float* color, double x, double y) {
            weight += w, squares += w * w;
            px += w * x, py += w * y;
            pxx += w * x * x, pxy += w * x * y, pyy += w * y * y;
            for (int c = 0; c < 3; ++c) {
                const double v = w * double(color[c]);
                rgb[c] += v, rgb_x[c] += v * x, rgb_y[c] += v * y;
                low[c] = std::min(low[c], color[c]), high[c] = std::max(high[c], color[c]);
            }
        }
        Pixel mean() const {
            Pixel out;
            if (!(weight > 0)) return out;
            for (int c = 0; c < 3; ++c) out.rgb[c] = rgb[c] / weight;
            out.effective = float(weight * weight / squares);
            return out;
        }
        // The mean that they would have around the filter's middle.
        Pixel fitted() const {
            Pixel out = mean();
            if (!(out.effective >= least_to_fit)) return out;
            const double x = px / weight, y = py / weight;
            const double xx = pxx / weight - x * x, xy = pxy / weight - x * y,
                         yy = pyy / weight - y * y, det = xx * yy - xy * xy;
            if (!(det > 1e-6 * xx * yy)) return out;
            for (int c = 0; c < 3; ++c) {
                const double fx = rgb_x[c] / weight - x * out.rgb[c],
                             fy = rgb_y[c] / weight - y * out.rgb[c];
                const double slope_x = (yy * fx - xy * fy) / det,
                             slope_y = (xx * fy - xy * fx) / det;
                out.rgb[c] = std::clamp(out.rgb[c] - slope_x * x - slope_y * y, double(low[c]),
                                        double(high[c]));
            }
            return out;
        }
    };

  private:
    // Of all samples that a filter takes; along its way, where it moves and that is all.
    Pixel gathered(const Filter& filter) const;
    Pixel gathered_along(const Filter& filter) const;
    float weight(const Filter& filter, size_t sample) const;
    float lens_weight(const Filter& filter, float dx, float dy, float u, float v) const;
    float pieces_weight(const Filter& filter, Interval x, Interval y, float u, float v) const;
    float time_weight(const Filter& filter, float dx, float dy, float t) const;
    float pad_x(const Filter& f) const {
        return f.half_x + overhang_ + std::abs(f.coc_x) * f.reach_lens;
    }
    float pad_y(const Filter& f) const {
        return f.half_y + overhang_ + std::abs(f.coc_y) * f.reach_lens;
    }
    // The pixels, first and last, of [0, size) that come within `pad` of [from, to].
    static std::array<int, 2> pixels_between(float from, float to, float pad, int size) {
        const auto pixel = [size](float at) {
            return int(std::clamp(std::floor(at), -1.0f, float(size)));
        };
        return {std::max(pixel(from - pad), 0), std::min(pixel(to + pad), size - 1)};
    }

    const Samples& samples_;
    SamplePaths paths_;
    std::optional<SlopeReader> slopes_;
    ShearedSettings settings_;
    LensCuts cuts_;
    bool round_;
    ShutterCurve shutter_;
    std::span<const float> rgb_, weight_;
    double mean_time_ = 0.5, time_second_ = 1 / 12.0, time_third_ = 0;  // about the mean
    float overhang_ = 0;  // px: how far any sample lies outside its pixel
};

template <class Take>
void ShearedFilter::gather(const Filter& f, const Take& take) const {
    const float way_x = f.moves ? f.vx * f.reach_t : 0, way_y = f.moves ? f.vy * f.reach_t : 0;
    const float rise = std::abs(way_y), run = way_y < 0 ? -way_x : way_x, pad = pad_y(f);
    const auto [first, last] = pixels_between(f.y - rise, f.y + rise, pad, samples_.height);
    for (int j = first; j <= last; ++j) {
        // The part of the line, in [-1, 1], that comes near this row.
        float from = -1, to = 1;
        if (rise > 0) {
            from = std::clamp((float(j) - pad - f.y) / rise, -1.0f, 1.0f);
            to = std::clamp((float(j + 1) + pad - f.y) / rise, -1.0f, 1.0f);
        }
        const float a = f.x + run * from, b = f.x + run * to;
        const auto [left, right] =
            pixels_between(std::min(a, b), std::max(a, b), pad_x(f), samples_.width);
        for (int k = left; k <= right; ++k) {
            const auto range = samples_.of_pixel(size_t(j) * size_t(samples_.width) + size_t(k));
            // Where samples lie denser, each stands for less.
            const double each = range.end > range.begin ? 1 / double(range.end - range.begin) : 0;
            for (size_t i = range.begin; i < range.end; ++i) {
                const float w = weight(f, i);
                const float* color = &rgb_[3 * i];
                if (w > 0 && std::isfinite(color[0] + color[1] + color[2]))
                    take(i, double(w) * (weight_.empty() ? each : double(weight_[i])));
            }
        }
    }
}

}  // namespace weft::adaptive
