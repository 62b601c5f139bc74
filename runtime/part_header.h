// The header of a part file as JSON.
#pragma once
#include <string_view>

#include "graph/json.h"
#include "runtime/part_file.h"

namespace weft {

Json to_json(const PartHeader& header);
// Throws Error naming `path` if a member is missing or makes no sense.
PartHeader part_header(std::string_view text, const std::string& path);

}  // namespace weft
