// Reading the native sample file, .npz (docs/formats.md): a zip of numpy arrays.
// Members that are stored, of type f4 and aligned are used where they lie in the file; others are
// inflated and converted, several at once. Only wanted members are touched; those are checked
// against their CRC-32, and their values by check_samples().
#pragma once
#include "samples/sample_file.h"

namespace weft {

// Whether these bytes are a zip file.
bool is_npz(const FileBytes& file);

// Throws Error where the file cannot be used; warns through `ctx` of what was dropped.
Samples read_npz(const FileBytes& file, const ReadOptions& options, Context& ctx);

}  // namespace weft
