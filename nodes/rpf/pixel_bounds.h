// Which pixels can hold samples that are near something, told by between which numbers theirs are
// (PixelBounds): a few bytes a pixel instead of the vectors of its samples.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "rpf/sample_vectors.h"
#include "runtime/context.h"

namespace weft::rpf {

// Fills vectors.bounds, unless pixels have few samples, which are compared as soon one by one, or
// some samples are not whole, which nobody is near.  Cost: two passes over the vectors.
void find_pixel_bounds(SampleVectors& vectors, Context& ctx);

// Which of a pixel's samples are near.
enum class PixelNear : std::uint8_t { none, some, all };

// Of a feature: a pixel that reaches from code `low` to `high` has none near where low > last or
// high < first, and all where low >= first_in and high <= last_in.
struct NearCodes {
    const std::uint8_t *low, *high;  // of each pixel
    std::uint8_t first, last, first_in, last_in;
};

// Of features that have to lie within `bound` of `centre`, where that is finite. None where vectors
// have no bounds.
void find_near_codes(const PixelBounds& bounds, std::span<const float> centre,
                     std::span<const float> bound, std::vector<NearCodes>& to);

}  // namespace weft::rpf
