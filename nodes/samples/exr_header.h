// The header of an OpenEXR file, as far as deep samples need it. Nothing it says is believed beyond
// the file's own length, so that no header can make a reader allocate much more than the file
// holds. Source: "OpenEXR File Layout" (ASWF), versions 2.0 with deep data and several parts.
#pragma once
#include <string>
#include <vector>

#include "samples/file_bytes.h"

namespace weft {

enum class ExrPixel { uint, half, single };
inline size_t size_of(ExrPixel type) {
    return type == ExrPixel::half ? 2 : 4;
}

struct ExrChannel {
    std::string name;
    ExrPixel type = ExrPixel::single;
};

struct ExrHeader {
    int part = 0;          // index of this part
    bool several = false;  // whether chunks begin with a part number
    std::string type;      // "deepscanline", "scanlineimage", ...
    int compression = 0;   // 0 none, 1 RLE, 2 ZIP of one line
    int x0 = 0, y0 = 0;    // corner of the data window
    int width = 0, height = 0;
    std::vector<ExrChannel> channels;    // in file order
    std::string meta;                    // attribute weft:meta, or ""
    std::vector<std::uint64_t> offsets;  // of each line's chunk
};

bool is_exr(const FileBytes& file);
bool is_deep_exr(const FileBytes& file);  // of the flag in its first bytes

// The first deep scanline part. Throws Error naming the file where there is none, or what is wrong.
ExrHeader read_exr_header(const FileBytes& file);

}  // namespace weft
