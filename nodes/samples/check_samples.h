// What a reader says of bad values (docs/formats.md): one pass over every channel that was read,
// whatever format it came from.
//   radiance       NaN or infinite: dropped with a warning; negative: kept with a warning
//   z uv t xy      depth not above 0, lens position outside the disk, time outside the shutter,
//   motion alpha   position more than a pixel outside its pixel, not a number: dropped with a
//   weight         warning; more than `tolerate` of the buffer: Error
//   others         NaN: kept with a warning
// A sample is dropped from all channels, and samples a pixel then vary. Nothing is copied when
// nothing is dropped. Findings do not depend on the number of threads.
#pragma once
#include <string>

#include "samples/samples.h"

namespace weft {

class Context;

void check_samples(Samples& samples, const std::string& file, double tolerate, Context& ctx);

// "pixel (12, 7), sample 3" for camera buffers; "sample 81234" for those without pixels.
std::string place_of(const Samples& samples, size_t sample);

}  // namespace weft
