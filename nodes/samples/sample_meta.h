// The `meta` object of sample files (docs/formats.md): reading and checking it.
#pragma once
#include <string>

#include "graph/json.h"
#include "samples/samples.h"

namespace weft {

// Fills width, height, spp, colour space, domain, lens and meta of `samples` from the text of a
// meta object. Throws Error beginning with `file` when a key is missing or has an unusable value.
void read_meta(std::string_view text, const std::string& file, Samples& samples);

// The role that meta gives a channel, or else its standard one. Throws Error for an unknown role.
Role role_in_meta(const Json& meta, const std::string& file, std::string_view channel);

// meta_object() with the run's provenance, where there is one ("weft:graph", "weft:inputs",
// "weft:version").
class Context;
Json meta_to_write(const Samples& samples, const Context& ctx);

}  // namespace weft
