// EXR in memory: scanline pictures, half or float, through OpenEXR without its threads.
//   attributes  every Image attribute and the provenance as strings; chromaticities where the
//   colour
//               space is a known one; "oiio:ColorSpace" with its name; no date, so bytes repeat
//   half        finite values beyond its range are written as its largest
//   reading     scanline, tiled and multi-part; channels as R G B A, then the rest by name, layer
//   by
//               layer; the picture is the display window, zero where there is no data
#pragma once
#include "image/picture_file.h"

namespace weft {

std::string encode_exr(const Image& image, const PictureOptions& options,
                       std::vector<std::string>& warnings);
Image decode_exr(std::string_view bytes, const std::string& file, const std::string& part = {});
Shape exr_shape(const std::string& path);  // of the first part, by the file's header
PictureInfo exr_info(std::string_view bytes, const std::string& file);

}  // namespace weft
