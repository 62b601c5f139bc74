// What reading a sample file will give and need, told by its headers alone.
#pragma once
#include "runtime/node.h"
#include "samples/sample_file.h"

namespace weft {

// Width, height, records, and the bytes that will be allocated: channels used where they lie in the
// file count nothing, others by their unpacked size. Throws Error where a header is damaged.
Shape sample_shape(const FileBytes& file, const ReadOptions& options);

}  // namespace weft
