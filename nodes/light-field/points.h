// Points at which to reconstruct: positions in a pixel, on the lens and in the shutter, as functions of
// whole numbers alone.
//   lens_point    slice i of n: one (u, v, t), spread evenly over lens and shutter as i goes from 0 to n
//   pixel_point   where in its pixel a location of slice i lies; evenly spread together with (u, v, t)
// Source: (u, v) the first two dimensions of Sobol's sequence (Joe and Kuo 2008) and t = i / n, which is
// a Hammersley set; (x, y) the next two dimensions, xor-scrambled per pixel (Kollig and Keller 2002).
#pragma once
#include <array>
#include <cstdint>

#include "samples/lens_shape.h"
#include "samples/random.h"

namespace weft::light_field {

using weft::on_lens;

// px: blocks of the picture that share slices, aligned to it so that nothing depends on tiles.
inline constexpr int location_block = 32;
inline int blocks_across(int pixels) { return (pixels + location_block - 1) / location_block; }

struct LensPoint {
    float u, v, t;
};
// `seed` scrambles the set; u, v lie in the unit disk, or in a polygon inside it where the lens has blades.
LensPoint lens_point(std::uint64_t seed, std::uint32_t i, std::uint32_t n, const Lens& lens);

// Bits of dimensions 3 and 4 of Sobol's sequence.
std::array<std::uint32_t, 2> pixel_pattern(std::uint32_t i);
// Where slice i looks at a light from: dimension 0 or 1, in [0, 1); dimensions 5 and 6 of Sobol's sequence, so
// evenly spread together with (u, v, t) and (x, y).
float light_number(std::uint64_t seed, std::uint32_t i, int dimension);
std::uint64_t pixel_scramble(std::uint64_t seed, int x, int y);

}  // namespace weft::light_field
