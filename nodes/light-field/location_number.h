// A number of a location's own, for choices by chance.
#pragma once
#include <bit>

#include "samples/random.h"

namespace weft::light_field {

// In [0, 1), a function of where the location lies, and of a key.
inline float location_number(float x, float y, float u, float t, std::uint64_t key = 0) {
    const auto bits = [](float a, float b) {
        return std::uint64_t(std::bit_cast<std::uint32_t>(a)) << 32 |
               std::bit_cast<std::uint32_t>(b);
    };
    return unit_float(mix(mix(key ^ bits(x, y)) ^ bits(u, t)));
}

}  // namespace weft::light_field
