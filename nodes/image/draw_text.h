// Words in pictures: a bitmap font of our own, 5 x 8 dots a letter (the eighth row for what hangs
// below the line), 6 dots from one to the next. Printable ASCII; anything else is drawn as '?'.
#pragma once
#include <array>
#include <string_view>

#include "image/image.h"

namespace weft {

constexpr int letter_width = 6, letter_height = 8;  // dots, with the gap to the next

// Draws with the top left at (x, y), `size` pixels a dot, into R G B; what falls outside is left
// off.
void draw_text(Image& image, int x, int y, std::string_view text, int size,
               const std::array<float, 3>& color);

// Pixels across.
int text_width(std::string_view text, int size);

}  // namespace weft
