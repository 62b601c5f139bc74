// How far a picture is from its reference.
//   rmse      root of the mean squared difference of the values as they are, over pixels and R G B
//   rel_mse   mean of (a - b)^2 / (b^2 + 0.01), b the reference
// These two over all pixels, or by a weight a pixel; the others always over all.
//   psnr      dB, of un-tone-mapped sRGB in [0, 1]; infinite where equal
//   ssim      Wang et al. 2004 on the luma of the same: Gaussian window 11 x 11, deviation 1.5,
//             K1 = 0.01, K2 = 0.03; mean over pixels whose window lies inside
//   flip      mean LDR-FLIP of the same at 67 pixels a degree (image/flip.h)
// NaN and infinite values count as 0 in either picture and are reported.
#pragma once
#include <string>
#include <vector>

#include "image/image.h"
#include "image/table.h"
#include "runtime/context.h"

namespace weft {

struct Measures {
    double rmse = 0, rel_mse = 0, psnr = 0, ssim = 0, flip = 0;
};

enum class ErrorKind { flip, relative, absolute };

struct Comparison {
    Measures measures;
    Image error;  // of the kind asked for, false colour, sRGB
};

// Throws Error where sizes or colour spaces differ, or `where` (a weight a pixel, none below 0;
// null: all count alike) has another size or weighs nothing.
Comparison compare_pictures(const Image& picture, const Image& reference, Context& ctx,
                            ErrorKind kind = ErrorKind::flip, float range = 1,
                            const Image* where = nullptr);
// The same of two files (`weft compare`).
Comparison compare_files(const std::string& picture, const std::string& reference, Context& ctx);

// Columns "picture", "rmse", "relmse", "psnr", "ssim", "flip".
Table measures_table();
void add_row(Table& table, const std::string& name, const Measures& measures);

// One value a pixel, [0, 1] for flip, sqrt of the mean of (a-b)^2/(b^2+0.01) over R G B for
// relative, mean of |a - b| for absolute.
std::vector<float> error_map(const Image& picture, const Image& reference, ErrorKind kind,
                             Context& ctx);
// Dark blue over red to light yellow for 0 to `range`, sRGB.
Image false_color(const std::vector<float>& map, int width, int height, float range);

}  // namespace weft
