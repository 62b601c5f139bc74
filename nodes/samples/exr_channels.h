// How channels are called in a deep EXR (docs/formats.md): rgb is R G B, z is Z, alpha is A, xy and
// uv are x y u v; of others, "name.part": parts R G B for radiance and albedo, else x y z w, else
// 0 1 2 ...; a channel of one component has its own name.
#pragma once
#include <string>
#include <string_view>

#include "samples/samples.h"

namespace weft {

// Of component `part` of `channel`.
std::string exr_name(const Channel& channel, int part);

// Which channel, and which of its components, a name stands for. Reading takes R G B A and r g b a,
// x y z w and numbers for any channel.
struct ExrPart {
    std::string channel;
    int part = 0;
};
ExrPart exr_part(std::string_view name);

}  // namespace weft
