// Reading deep EXR: one deep sample is one camera sample (docs/formats.md). Lines are unpacked side
// by side. Departure: the chunks are read by our own code and not through the OpenEXR library,
// whose deep reader of this age trusts the sizes that it finds in a file.
#pragma once
#include "samples/sample_file.h"

namespace weft {

Samples read_deep_exr(const FileBytes& file, const ReadOptions& options, Context& ctx);

}  // namespace weft
