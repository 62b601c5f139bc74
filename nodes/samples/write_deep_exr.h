// Writing deep EXR (scanlines, floats; whole-number channels as uint): one deep sample is one
// camera sample. Channel names: exr_channels.h. Lens and everything else of meta: attribute
// weft:meta.
#pragma once
#include "samples/sample_file.h"

namespace weft {

// Throws Error for a buffer without pixels (domain "light"). Warns of channels whose name means
// something else in this format; they are left out.
void write_deep_exr(const Samples& samples, const std::string& path, bool deflate, Context& ctx);

}  // namespace weft
