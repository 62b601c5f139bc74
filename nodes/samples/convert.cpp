#include "samples/convert.h"

#include <bit>

#include "samples/little_endian.h"

namespace weft {

// The exponent is rebiased by 112, twice for infinity and NaN. A denormal half is given an exponent
// of one, which is then subtracted as a number, so that no denormal float is ever computed with
// (render threads may have those flushed to zero).
float float_from_half(std::uint16_t half) {
    const std::uint32_t bits = std::uint32_t(half & 0x7fff) << 13;
    const std::uint32_t rebias = 112u << 23;
    const std::uint32_t normal = bits + rebias;
    const std::uint32_t special = bits >= (0x1fu << 23) ? rebias : 0;
    const float small = std::bit_cast<float>(bits + (113u << 23)) - 0x1p-14f;
    const std::uint32_t magnitude =
        bits < (1u << 23) ? std::bit_cast<std::uint32_t>(small) : normal + special;
    return std::bit_cast<float>(magnitude | std::uint32_t(half & 0x8000) << 16);
}

void floats_from_halves(std::span<const std::uint8_t> halves, std::span<float> floats) {
    for (size_t i = 0; i < floats.size(); ++i)
        floats[i] = float_from_half(number_at<std::uint16_t>(halves, 2 * i));
}

}  // namespace weft
