#include "samples/sample_file.h"

#include <fmt/format.h>

#include "graph/error.h"
#include "samples/exr_header.h"
#include "samples/read_deep_exr.h"
#include "samples/read_npz.h"

namespace weft {

std::string_view name_of(SampleFormat format) {
    switch (format) {
        case SampleFormat::npz: return "npz";
        case SampleFormat::deep_exr: return "deep EXR";
        case SampleFormat::tlfr: return "TLFR 1.3";
        case SampleFormat::ilfr: break;
    }
    return "ILFR 2.2";
}

std::optional<SampleFormat> format_of(const FileBytes& file) {
    if (is_npz(file)) return SampleFormat::npz;
    if (is_deep_exr(file)) return SampleFormat::deep_exr;
    return std::nullopt;
}

Samples read_sample_file(const FileBytes& file, const ReadOptions& options, Context& ctx) {
    if (is_npz(file)) return read_npz(file, options, ctx);
    if (is_deep_exr(file)) return read_deep_exr(file, options, ctx);
    throw Error(fmt::format("{}: no sample file that this program knows; expected .npz or deep EXR",
                            file.name));
}

}  // namespace weft
