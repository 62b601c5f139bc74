// PNG in memory, 8 and 16 bit, through libpng.
//   values   [0, 1], clamped and rounded; NaN is written as 0
//   colour   sRGB, gAMA, cHRM or cICP by the picture's display; text chunks (iTXt) for attributes
//   speed    level 1 and one filter by default: a preview must not cost more than the picture
#pragma once
#include "image/picture_file.h"

namespace weft {

std::string encode_png(const Image& image, const PictureOptions& options,
                       std::vector<std::string>& warnings);
Image decode_png(std::string_view bytes, const std::string& file);
PictureInfo png_info(std::string_view bytes, const std::string& file);

}  // namespace weft
