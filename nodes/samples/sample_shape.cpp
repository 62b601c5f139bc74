#include "samples/sample_shape.h"

#include "samples/channel_choice.h"
#include "samples/exr_header.h"
#include "samples/npy.h"
#include "samples/read_npz.h"
#include "samples/record_file.h"
#include "samples/sample_meta.h"
#include "samples/zip_reader.h"

namespace weft {
namespace {

Shape npz_shape(const FileBytes& file, const ReadOptions& options) {
    constexpr std::string_view ending = ".npy";
    Shape shape;
    for (const ZipMember& member : zip_members(file)) {
        if (!member.name.ends_with(ending)) continue;
        const std::string_view name =
            std::string_view(member.name).substr(0, member.name.size() - ending.size());
        if (name == "meta") {
            const FileBytes bytes = zip_bytes(file, member);
            const Npy array = parse_npy(bytes.bytes, file.name + ": 'meta'");
            Samples head;
            read_meta({reinterpret_cast<const char*>(array.data.data()), array.data.size()},
                      file.name, head);
            shape.width = head.width;
            shape.height = head.height;
            if (head.spp > 0) shape.records = std::int64_t(head.pixels()) * head.spp;
        } else if (name == "xy" && shape.records == 0) {
            shape.records = std::int64_t(member.size / (2 * sizeof(float)));
        }
        if (is_wanted(options, name)) {
            ++shape.channels;
            if (member.method != 0) shape.bytes += double(member.size);
        }
    }
    return shape;
}

}  // namespace

Shape sample_shape(const FileBytes& file, const ReadOptions& options) {
    if (is_npz(file)) return npz_shape(file, options);
    if (is_deep_exr(file)) {
        const ExrHeader header = read_exr_header(file);
        // How many samples there are stands in the lines alone; packed floats rarely shrink below
        // half.
        return {header.width, header.height, std::int64_t(header.channels.size()), 0,
                2.0 * double(file.bytes.size())};
    }
    if (const auto files = find_record_files(file)) {
        const RecordHeader header = read_record_header(files->header);
        const double floats = double(header.records()) * double(header.floats());
        return {header.width, header.height, std::int64_t(header.floats()),
                std::int64_t(header.records()), 4 * floats};
    }
    return {};  // reading it will say what is wrong
}

}  // namespace weft
