// Colour in file headers: primaries of the scene-linear spaces, what PNG says of each display, and
// the text that goes with a picture.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "image/image.h"
#include "runtime/context.h"

namespace weft {

// CIE 1931 xy of red, green, blue and white.
struct Primaries {
    float rx, ry, gx, gy, bx, by, wx, wy;
};

// Of a scene-linear space by any of its usual names ("ACEScg", "lin_ap1"), or nullptr.
const Primaries* primaries_of(std::string_view color_space);
// The other way round, within 1e-3; "" where none fits.
std::string space_of_primaries(const Primaries& primaries);

// Whether a name is one of the scene-linear spaces that have primaries above.
inline bool is_scene_linear(std::string_view color_space) {
    return primaries_of(color_space) != nullptr;
}

// How display values are encoded: what PNG's chunks need. Names as ITU-T H.273 numbers them.
struct DisplayTag {
    std::uint8_t primaries, transfer;  // cICP
    Primaries xy;                      // cHRM
    double gamma;                      // gAMA, nearest power
    bool srgb;                         // the sRGB chunk says it all
};
// Of a display or display space ("sRGB - Display", "Rec.2100-PQ"), or nullptr.
const DisplayTag* display_tag(std::string_view color_space);
// "sRGB - Display" and so on for cICP's numbers; "" where not known.
std::string display_of_cicp(int primaries, int transfer);

// Image::attributes, display and view, and the provenance in place of whatever an input brought.
std::map<std::string, std::string> text_to_write(const Image& image, const Provenance& provenance);

}  // namespace weft
