// Writing the native sample file, .npz (docs/formats.md). Stored members start at multiples of 64,
// so that reading them back maps them.
#pragma once
#include "samples/sample_file.h"

namespace weft {

void write_npz(const Samples& samples, const std::string& path, bool deflate, Context& ctx);

}  // namespace weft
