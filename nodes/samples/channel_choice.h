// Which of a file's channels are read.
#pragma once
#include "samples/sample_file.h"

namespace weft {

// xy uv t z motion rgb alpha weight z_gradient
bool is_basic_channel(std::string_view channel);

// Whether `options` ask for this channel of a file.
bool is_wanted(const ReadOptions& options, std::string_view channel);

// Throws Error where `options` name a channel that is neither standard nor among `known`.
void refuse_unknown_channels(const ReadOptions& options, const std::string& file,
                             const std::vector<std::string>& known);

}  // namespace weft
