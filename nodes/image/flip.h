// LDR-FLIP: how different two pictures look when one replaces the other on a screen, a value in [0,
// 1] a pixel; its mean is the usual measure.
//   reference, test   sRGB values in [0, 1], same size
//   ppd               pixels a degree of the viewer's eye
//   returns           width x height, row by row
// Source: Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", Sec. 4.
// Departure: filters are separable (their Gaussians are), which differs in rounding only.
// Cost: about 400 operations a pixel and 12 floats of scratch.
#pragma once
#include <vector>

#include "image/display_values.h"

namespace weft {

constexpr float usual_pixels_per_degree = 67;

std::vector<float> flip_map(const RgbPixels& reference, const RgbPixels& test, float ppd,
                            Context& ctx);

}  // namespace weft
