// The OpenColorIO config that Weft ships: its text. Made of OpenColorIO's built-in transforms and a
// few matrices, so it needs no LUT files. Scene-linear ACEScg (the role), lin_rec709, lin_rec2020,
// lin_p3d65 and ACES2065-1; displays sRGB, Rec.709, Display P3 and Rec.2100-PQ; ACES views,
// Un-tone-mapped and Raw.
#pragma once
#include <string_view>

namespace weft {

std::string_view shipped_config_text();

}  // namespace weft
