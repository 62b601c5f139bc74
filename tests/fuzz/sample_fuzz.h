// What the fuzzers of sample readers and the replay of their corpora do with one input: it is read,
// or refused with a message; what was read must be consistent.
#pragma once
#include <libdeflate.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "graph/error.h"
#include "runtime/context.h"
#include "samples/exr_header.h"
#include "samples/ilfr.h"
#include "samples/read_deep_exr.h"
#include "samples/read_npz.h"
#include "samples/record_file.h"
#include "samples/tlfr.h"
#include "samples/zip_reader.h"

namespace weft::test {

[[noreturn]] inline void not_consistent(const char* what, const std::string& channel = "") {
    std::fprintf(stderr, "read, but %s %s\n", what, channel.c_str());
    std::abort();
}

inline void check_consistent(const Samples& s) {
    if (s.size() == 0) not_consistent("empty");
    for (const Channel& c : s.channels) {
        const size_t values = c.whole() ? c.ids.size() : c.values.size();
        if (c.components < 1 || values != s.size() * size_t(c.components))
            not_consistent("of the wrong size:", c.name);
    }
    for (const float v : s.rgb())
        if (v - v != 0) not_consistent("radiance is no number in", "rgb");
    for (const float z : s.z())
        if (!(z > 0)) not_consistent("depth is not above 0 in", "z");
    if (s.domain != "camera") return;
    if (s.spp == 0 && s.first.size() != s.pixels() + 1) not_consistent("without counts");
    size_t end = 0;
    for (size_t pixel = 0; pixel < s.pixels(); ++pixel) {
        const Samples::Range range = s.of_pixel(pixel);
        if (range.begin != end || range.end < range.begin)
            not_consistent("counts are out of order");
        end = range.end;
    }
    if (end != s.size()) not_consistent("counts don't add up");
}

template <class Read>
void read_or_refuse(Read&& read) {
    PlainContext ctx;
    try {
        const Samples samples = read(ReadOptions{.channels = {"*"}, .tolerate = 0.5}, ctx);
        check_consistent(samples);
    } catch (const Error& error) {
        if (error.what()[0] == '\0') not_consistent("refused without a word");
    }
}

// Makes checksums right, which no fuzzer would guess: of each member, where it can be unpacked.
inline std::string with_checksums(std::string bytes) {
    const FileBytes file{
        "a", {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, nullptr, false};
    std::vector<ZipMember> members;
    try {
        members = zip_members(file);
    } catch (const Error&) {
        return bytes;
    }
    std::string fixed = bytes;
    size_t at = 0;
    for (ZipMember& member : members) {
        at = fixed.find("PK\1\2", at);
        if (at == fixed.npos || fixed.size() - at < 20) break;
        std::vector<std::uint8_t> plain(member.packed.begin(), member.packed.end());
        if (member.method == 8 && member.size < 1032 * (member.packed.size() + 1)) {
            plain.resize(size_t(member.size) + 1);
            libdeflate_decompressor* inflater = libdeflate_alloc_decompressor();
            libdeflate_deflate_decompress(inflater, member.packed.data(), member.packed.size(),
                                          plain.data(), size_t(member.size), nullptr);
            libdeflate_free_decompressor(inflater);
            plain.pop_back();
        }
        const std::uint32_t crc = libdeflate_crc32(0, plain.data(), plain.size());
        std::memcpy(&fixed[at + 16], &crc, 4);
        at += 4;
    }
    return fixed;
}

inline void fuzz_npz(std::string_view input) {
    const std::string bytes = with_checksums(std::string(input));
    const FileBytes file{
        "a", {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, nullptr, false};
    read_or_refuse(
        [&](const ReadOptions& options, Context& ctx) { return read_npz(file, options, ctx); });
}

inline void fuzz_deep_exr(std::string_view input) {
    const FileBytes file{
        "a", {reinterpret_cast<const std::uint8_t*>(input.data()), input.size()}, nullptr, false};
    read_or_refuse([&](const ReadOptions& options, Context& ctx) {
        if (!is_deep_exr(file)) throw Error("no deep EXR");
        return read_deep_exr(file, options, ctx);
    });
}

// A header, and behind it the data, text or binary.
inline void fuzz_records(std::string_view input, RecordKind kind) {
    const FileBytes file{
        "a", {reinterpret_cast<const std::uint8_t*>(input.data()), input.size()}, nullptr, false};
    read_or_refuse([&](const ReadOptions& options, Context& ctx) {
        const RecordHeader header = read_record_header(file);
        if (header.kind != kind) throw Error("of the other kind");
        RecordFiles files{file, file};
        if (!header.text) files.data.bytes = file.bytes.subspan(header.size);
        return kind == RecordKind::tlfr ? read_tlfr(files, header, options, ctx)
                                        : read_ilfr(files, header, options, ctx);
    });
}
inline void fuzz_tlfr(std::string_view input) {
    fuzz_records(input, RecordKind::tlfr);
}
inline void fuzz_ilfr(std::string_view input) {
    fuzz_records(input, RecordKind::ilfr);
}

}  // namespace weft::test
