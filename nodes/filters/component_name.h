// What a sample channel's components are called in a picture: "roughness", "normal.x", "sh.7".
#pragma once
#include <fmt/format.h>

#include <string>

#include "samples/samples.h"

namespace weft {

inline std::string component_name(const Channel& channel, int component) {
    if (channel.components == 1) return channel.name;
    if (channel.components <= 3) return channel.name + "." + "xyz"[component];
    return fmt::format("{}.{}", channel.name, component);
}

}  // namespace weft
