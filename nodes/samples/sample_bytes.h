// Sample buffers as bytes, for nodes that make them in bands of rows (node.h, "Shards"): each piece
// is a Samples of the whole width and the band's rows, its positions those in the whole picture.
#pragma once
#include "runtime/bytes.h"
#include "samples/samples.h"

namespace weft {

void put_samples(ByteWriter& to, const Samples& band);
Samples take_samples(ByteReader& from);  // throws Error

// All pieces, top to bottom, as one buffer: what the first says of colour, lens and meta holds for
// all. Throws Error if they do not go together.
Samples join_samples(const Pieces& pieces);

}  // namespace weft
