// PFM: a text header ("PF" colour or "Pf" grey, size, scale whose sign is the byte order), then
// rows of floats from the bottom up. Values are exact; there is no place for anything else.
#pragma once
#include "image/picture_file.h"

namespace weft {

std::string encode_pfm(const Image& image, std::vector<std::string>& warnings);
Image decode_pfm(std::string_view bytes, const std::string& file);
bool is_pfm(std::string_view bytes);

}  // namespace weft
