// Numbers of files to floats, many at once: plain loops without branches, for the compiler to
// widen.
#pragma once
#include <cstdint>
#include <span>

namespace weft {

// One IEEE half to float, exact for every one of the 65536 (NaN stays NaN).
float float_from_half(std::uint16_t half);

// `halves` are little-endian, at any address; two bytes for each of `floats`.
void floats_from_halves(std::span<const std::uint8_t> halves, std::span<float> floats);

}  // namespace weft
