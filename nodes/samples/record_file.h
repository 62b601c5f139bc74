// What TLFR 1.3 and ILFR 2.2 share: a text header (NAME.header, or the start of NAME) and records
// of a fixed number of floats, as text or as raw little-endian IEEE numbers; the same number of
// records for every pixel, row by row. Source: the formats of the code published with Lehtinen et
// al. 2011 and 2012. Departure: numbers are written with 9 digits, so that text is exact; files of
// any other length are refused.
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "samples/file_bytes.h"
#include "samples/samples.h"

namespace weft {

class Context;

enum class RecordKind { tlfr, ilfr };

struct RecordHeader {
    RecordKind kind = RecordKind::tlfr;
    int width = 0, height = 0, spp = 0;
    float c0 = 0, c1 = 0;
    std::array<float, 16> pixel_to_camera{};  // ILFR; row by row
    bool text = false;
    size_t size = 0;  // bytes of the header's text
    size_t records() const { return size_t(width) * size_t(height) * size_t(spp); }
    size_t floats() const { return kind == RecordKind::tlfr ? 16 : 39; }  // a record
};

// Of a file's first bytes: whether it is a header of any version.
bool is_record_header(const FileBytes& file);

// Throws Error naming the file and the line.
RecordHeader read_record_header(const FileBytes& file);
std::string record_header_text(const RecordHeader& header);

// The two files of a pair, whichever of them `file` is; none if it is no such file.
struct RecordFiles {
    FileBytes header, data;  // the same where the header is the start of the data
};
std::optional<RecordFiles> find_record_files(const FileBytes& file);

// All records, one after the other; in place where they are binary and aligned. Throws Error.
Array<float> read_records(const RecordFiles& files, const RecordHeader& header, Context& ctx);

// Writes path and path.header. record(i, values) fills in one record.
void write_records(const std::string& path, const RecordHeader& header, Context& ctx,
                   const std::function<void(size_t, std::span<float>)>& record);

}  // namespace weft
