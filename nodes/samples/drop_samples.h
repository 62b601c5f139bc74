// Taking samples out of a buffer.
#pragma once
#include <span>

#include "samples/samples.h"

namespace weft {

// The pixel that a sample belongs to; camera buffers only.
size_t pixel_of(const Samples& samples, size_t sample);

// Takes the samples with these indices (ascending, each once) out of all channels. Samples a pixel
// vary afterwards: `spp` is 0 and `first` set, but for buffers without pixels (domain "light").
void drop_samples(Samples& samples, std::span<const size_t> dropped);

}  // namespace weft
