#include "samples/channel_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "graph/error.h"

namespace weft {

bool is_basic_channel(std::string_view channel) {
    for (std::string_view basic :
         {"xy", "uv", "t", "z", "motion", "rgb", "alpha", "weight", "z_gradient"})
        if (channel == basic) return true;
    return false;
}

bool is_wanted(const ReadOptions& options, std::string_view channel) {
    if (is_basic_channel(channel)) return true;
    return std::any_of(options.channels.begin(), options.channels.end(),
                       [&](const std::string& name) { return name == "*" || name == channel; });
}

void refuse_unknown_channels(const ReadOptions& options, const std::string& file,
                             const std::vector<std::string>& known) {
    for (const std::string& name : options.channels) {
        if (name == "*" || is_standard_channel(name)) continue;
        if (std::find(known.begin(), known.end(), name) == known.end())
            throw Error(fmt::format("{}: no channel '{}'{}", file, name, suggestion(name, known)));
    }
}

}  // namespace weft
