// Runs a colour transform over a picture: R G B, or Y as grey; alpha (A) and all other channels
// stay. Premultiplied colour is divided by its alpha before and multiplied after. NaN becomes 0
// and an infinite value +-65504 first (one becomes NaN in many transforms), with a warning of how
// many.
#pragma once
#include "color/color_config.h"
#include "image/image.h"
#include "runtime/context.h"

namespace weft {

Image apply_color(const Image& image, const ColorTransform& transform, Context& ctx);

// The space a picture's values are in: `from` where given, else its own, else lin_rec709 with a
// warning.
std::string space_of(const Image& image, const std::string& from, Context& ctx);

}  // namespace weft
