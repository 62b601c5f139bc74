// Sample files of any format: what a caller asks for, reading by content, writing by name.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "samples/file_bytes.h"
#include "samples/samples.h"

namespace weft {

class Context;

enum class SampleFormat { npz, deep_exr, tlfr, ilfr };
std::string_view name_of(SampleFormat format);  // "npz", "deep EXR", "TLFR 1.3", "ILFR 2.2"

struct ReadOptions {
    // Channels to read beside the basic ones (below); "*": all that the file holds. A standard name
    // that the file lacks is passed over; another is an error.
    std::vector<std::string> channels = {};
    double tolerate = 0.01;  // part of the samples that may be unusable
};

struct WriteOptions {
    std::optional<SampleFormat> format = {};  // none: by the file's extension
    bool deflate = false;                     // npz and deep EXR: pack without loss
    bool text = false;                        // TLFR and ILFR: text instead of binary
};

// The format of a file, told by its first bytes (TLFR and ILFR data: by their .header); none if
// Weft does not know it.
std::optional<SampleFormat> format_of(const FileBytes& file);

// Throws Error where the file cannot be used; warns through `ctx` of values that were dropped or
// are suspicious.
Samples read_sample_file(const FileBytes& file, const ReadOptions& options, Context& ctx);

// Written whole or not at all. Warns of what the format cannot hold; throws Error where that is
// something that cannot be left out.
void write_sample_file(const Samples& samples, const std::string& path, const WriteOptions& options,
                       Context& ctx);

}  // namespace weft
