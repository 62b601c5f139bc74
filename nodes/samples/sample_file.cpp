#include "samples/sample_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "graph/error.h"
#include "samples/exr_header.h"
#include "samples/ilfr.h"
#include "samples/read_deep_exr.h"
#include "samples/read_npz.h"
#include "samples/record_file.h"
#include "samples/tlfr.h"
#include "samples/write_deep_exr.h"
#include "samples/write_npz.h"

namespace weft {
namespace {

[[noreturn]] void refuse(const FileBytes& file) {
    if (file.bytes.empty()) throw Error(fmt::format("{}: the file is empty", file.name));
    if (is_exr(file))
        throw Error(
            fmt::format("{}: an EXR picture without deep samples; expected a deep EXR, or use "
                        "read-image",
                        file.name));
    throw Error(
        fmt::format("{}: no sample file that this program knows; expected .npz, deep EXR, TLFR 1.3 "
                    "or ILFR 2.2 (data of the last two have their header in '{}.header')",
                    file.name, file.name));
}

SampleFormat format_by_name(const std::string& path) {
    std::string ending =
        path.substr(path.find_last_of("./") == path.npos ? path.size() : path.find_last_of("./"));
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    if (ending == ".npz") return SampleFormat::npz;
    if (ending == ".exr") return SampleFormat::deep_exr;
    if (ending == ".tlfr") return SampleFormat::tlfr;
    if (ending == ".ilfr") return SampleFormat::ilfr;
    throw Error(
        fmt::format("'{}' does not say which format to write; name it .npz, .exr, .tlfr or .ilfr, "
                    "or set 'format'",
                    path));
}

}  // namespace

std::string_view name_of(SampleFormat format) {
    switch (format) {
        case SampleFormat::npz:
            return "npz";
        case SampleFormat::deep_exr:
            return "deep EXR";
        case SampleFormat::tlfr:
            return "TLFR 1.3";
        case SampleFormat::ilfr:
            break;
    }
    return "ILFR 2.2";
}

std::optional<SampleFormat> format_of(const FileBytes& file) {
    if (is_npz(file)) return SampleFormat::npz;
    if (is_deep_exr(file)) return SampleFormat::deep_exr;
    if (const auto files = find_record_files(file))
        return read_record_header(files->header).kind == RecordKind::tlfr ? SampleFormat::tlfr
                                                                          : SampleFormat::ilfr;
    return std::nullopt;
}

Samples read_sample_file(const FileBytes& file, const ReadOptions& options, Context& ctx) {
    if (is_npz(file)) return read_npz(file, options, ctx);
    if (is_deep_exr(file)) return read_deep_exr(file, options, ctx);
    const auto files = find_record_files(file);
    if (!files) refuse(file);
    const RecordHeader header = read_record_header(files->header);
    return header.kind == RecordKind::tlfr ? read_tlfr(*files, header, options, ctx)
                                           : read_ilfr(*files, header, options, ctx);
}

void write_sample_file(const Samples& samples, const std::string& path, const WriteOptions& options,
                       Context& ctx) {
    switch (options.format ? *options.format : format_by_name(path)) {
        case SampleFormat::npz:
            return write_npz(samples, path, options.deflate, ctx);
        case SampleFormat::deep_exr:
            return write_deep_exr(samples, path, options.deflate, ctx);
        case SampleFormat::tlfr:
            return write_tlfr(samples, path, options.text, ctx);
        case SampleFormat::ilfr:
            return write_ilfr(samples, path, options.text, ctx);
    }
}

}  // namespace weft
