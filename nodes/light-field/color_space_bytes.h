// The colour space of a tile's radiance, from a shard to the merge. None: no batch came by.
#pragma once
#include <string>

#include "runtime/bytes.h"

namespace weft {

inline void save_color_space(const std::string* space, ByteWriter& to) {
    to.put(std::uint8_t(space != nullptr));
    if (space) to.put_text(*space);
}

// Put into `keep`, which must live as long as what is returned is looked at.
inline const std::string* load_color_space(ByteReader& from, std::string& keep) {
    if (from.take<std::uint8_t>() == 0) return nullptr;
    keep = from.take_text();
    return &keep;
}

}  // namespace weft
