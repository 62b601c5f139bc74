// Slopes of a picture's light field over time and lens, bounded pixel by pixel, and what follows
// from them. What is seen at film position x at time t (or from lens position u) is constant along
// x + s t with s = -v, v the speed in px a shutter (x + s u with s = -coc, px a unit of lens); so
// its spectrum lies on lines of slope s, between the bounds in a wedge.
//   W   cycles a px: how fast the picture can vary where the integral over the window leaves it
//       anything, min(W_p, W_y / |s|_min): W_p = 0.5 the pixel's limit, W_y that of the window
//   B   cycles a unit of window: what is left of the wedge's width along the window once it is
//       sheared by the mean slope, (s_hi - s_lo) / 2 W
// Source: Egan et al. 2009, Sec. 4; constants of windows: the first zero of a box shutter's
// transform, and of a disc's.
#pragma once
#include <algorithm>
#include <cmath>
#include <string_view>

#include "image/image.h"

namespace weft::adaptive {

inline constexpr double pixel_band = 0.5;  // W_p
inline constexpr double shutter_band = 1;  // of a box of length 1
inline constexpr double lens_band = 0.61;  // of the unit disc

// Of an image that slope-bounds made; which effects it holds is told by its channels.
struct PixelSlopes {
    bool known = false;                   // paths enough crossed this pixel
    bool motion = false, lens = false;    // what the image holds
    double lo = 0, hi = 0;                // along n, px a shutter; s = -v
    double nx = 1, ny = 0;                // of the fastest path
    double across_lo = 0, across_hi = 0;  // along (-ny, nx)
    double lens_lo = 0, lens_hi = 0;      // px a unit of lens; s = -coc

    double least() const { return least_of(lo, hi); }
    double lens_least() const { return least_of(lens_lo, lens_hi); }
    // Mean velocity, px a shutter, and mean radius of the circle of confusion.
    double vx() const { return -(nx * (lo + hi) - ny * (across_lo + across_hi)) / 2; }
    double vy() const { return -(ny * (lo + hi) + nx * (across_lo + across_hi)) / 2; }
    double coc() const { return -(lens_lo + lens_hi) / 2; }

    // Bands along n and across it.
    double band() const {
        return std::min(band_across(), least() > 0 ? shutter_band / least() : pixel_band);
    }
    double band_across() const {
        return std::min(pixel_band, lens_least() > 0 ? lens_band / lens_least() : pixel_band);
    }
    // What shearing leaves along time and along the lens.
    double residual() const {
        return std::hypot((hi - lo) / 2 * band(), (across_hi - across_lo) / 2 * band_across());
    }
    double lens_residual() const { return (lens_hi - lens_lo) / 2 * band_across(); }

  private:
    static double least_of(double a, double b) {
        return a <= 0 && b >= 0 ? 0 : std::min(std::abs(a), std::abs(b));
    }
};

// Finds the channels; throws Error, as `who`, where they are not those of slope-bounds.
class SlopeReader {
  public:
    SlopeReader(const Image& slopes, std::string_view who);
    PixelSlopes operator()(int x, int y) const;
    bool motion() const { return lo_ >= 0; }
    bool lens() const { return lens_lo_ >= 0; }

  private:
    const Image& slopes_;
    int count_, lo_, lens_lo_;
};

}  // namespace weft::adaptive
