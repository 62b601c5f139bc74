// The axis-aligned filter: means of pixels around, as wide as each pixel's own width says.
//   weight   exp(-3 (D / beta)^2), 0 from D = beta on: a Gaussian of deviation 0.41 beta
//   D        the distance of two pixels: in px, along a direction of each pixel's own, or between
//            places on a plane
// The change against the pixel itself is what is averaged, so that a constant stays what it is.
// Source: Mehta et al. 2012, Sec. 5 (shadows); Egan et al. 2009, Sec. 5 (motion).
#pragma once
#include "image/image.h"
#include "runtime/context.h"

namespace weft::kernel {

// Which pixels pass for the same surface.
struct SurfaceGuard {
    const Image* features = nullptr;  // normal.x .., position.x .., z, id: those there are
    float normal_angle = 20;          // degrees
    float depth = 0.1f;               // parts of a pixel's z, or of its position.z
    float width_ratio = 3;            // of both pixels' beta
};

struct FilterWidths {
    const Image* image;
    int beta, radius = -1, x = -1, y = -1;  // channels; -1: px
    int nx = -1, ny = -1;                   // direction; -1: all round
    int reach = 64;                         // px
};

// How pixels around `at` would weigh: 0 where they are another surface.
class GuardedWeights {
  public:
    GuardedWeights(const FilterWidths& widths, const SurfaceGuard& guard);
    float radius(int x, int y) const;                    // px
    float operator()(int x, int y, int i, int j) const;  // of pixel (i, j) at (x, y)
    float weight(float distance, float beta) const;
    bool alike(int x, int y, int i, int j) const;

  private:
    FilterWidths widths_;
    SurfaceGuard guard_;
    int normal_ = -1, position_ = -1, z_ = -1, id_ = -1;
    float least_cosine_;
};

// All round: two passes, along rows and along columns.
Image filter_all_round(const Image& image, const FilterWidths& widths, const SurfaceGuard& guard,
                       Context& ctx);
// Along each pixel's direction: steps of a pixel along its longer part, between two pixels across.
Image filter_along(const Image& image, const FilterWidths& widths, const SurfaceGuard& guard,
                   Context& ctx);

}  // namespace weft::kernel
