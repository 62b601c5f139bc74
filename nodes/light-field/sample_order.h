// Sorting of samples by whole-number keys.
// Cost: linear but for short sorts of what lies together; 4 bytes a sample beside the keys.
// Threads: through the context; what comes out does not depend on them.
#pragma once
#include <cstdint>

#include "runtime/context.h"
#include "runtime/large_array.h"

namespace weft::light_field {

// The order of ascending keys, equal ones as they were. Keys lie within 2^52 of each other.
LargeArray<std::uint32_t> sorted(LargeArray<std::uint64_t> keys, Context& ctx);

}  // namespace weft::light_field
