// Finds what the samples of each pixel say together (sample_vectors.h has the planes).
#pragma once
#include "rpf/sample_vectors.h"
#include "runtime/context.h"

namespace weft::rpf {

// Fills vectors.pixels.  Cost: two passes over the vectors.
void find_pixel_statistics(SampleVectors& vectors, Context& ctx);

}  // namespace weft::rpf
