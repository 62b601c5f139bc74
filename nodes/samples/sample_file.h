// Sample files, of any format: what a caller asks for, and reading and writing by content and name.
#pragma once
#include <string>
#include <vector>

#include "samples/file_bytes.h"
#include "samples/samples.h"

namespace weft {

class Context;

struct ReadOptions {
    // Channels to read beside the basic ones (below); "*": all that the file holds. A standard name
    // that the file lacks is passed over; another is an error.
    std::vector<std::string> channels;
    double tolerate = 0.01;  // part of the samples that may be unusable
};

// xy uv t z motion rgb alpha weight z_gradient
bool is_basic_channel(std::string_view channel);

// Whether `options` ask for this channel of a file.
bool is_wanted(const ReadOptions& options, std::string_view channel);

// Throws Error where `options` name a channel that is neither standard nor among `known`.
void refuse_unknown_channels(const ReadOptions& options, const std::string& file,
                             const std::vector<std::string>& known);

// Reads a sample file of any format that Weft knows, told by its content. Throws Error where it
// cannot be used; warns through `ctx` of values that were dropped or are suspicious.
Samples read_sample_file(const FileBytes& file, const ReadOptions& options, Context& ctx);

}  // namespace weft
