#include "samples/write_npz.h"

#include <fmt/format.h>

#include "graph/error.h"
#include "runtime/atomic_file.h"
#include "runtime/context.h"
#include "samples/npy.h"
#include "samples/sample_meta.h"
#include "samples/zip_writer.h"

namespace weft {
namespace {

template <class T>
std::span<const std::uint8_t> bytes_of(std::span<const T> values) {
    return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()};
}

ZipPiece piece_of(const Channel& channel, size_t samples) {
    std::vector<std::uint64_t> shape{samples};
    if (channel.components > 1) shape.push_back(std::uint64_t(channel.components));
    const std::span<const std::uint8_t> data =
        channel.whole() ? bytes_of(channel.ids.view()) : bytes_of(channel.values.view());
    return {channel.name + ".npy", npy_header(channel.whole() ? "<u4" : "<f4", shape), data, {}, 0};
}

std::vector<std::uint32_t> counts_of(const Samples& samples) {
    std::vector<std::uint32_t> counts(samples.pixels());
    for (size_t pixel = 0; pixel < counts.size(); ++pixel) {
        const Samples::Range range = samples.of_pixel(pixel);
        counts[pixel] = std::uint32_t(range.end - range.begin);
    }
    return counts;
}

}  // namespace

void write_npz(const Samples& samples, const std::string& path, bool deflate, Context& ctx) {
    const std::string meta = meta_to_write(samples, ctx).dump();
    std::vector<std::uint32_t> counts;
    std::vector<ZipPiece> pieces;
    const std::span<const char> text(meta);
    pieces.push_back({"meta.npy", npy_header("|u1", {meta.size()}), bytes_of(text), {}, 0});
    if (!samples.first.empty()) {
        counts = counts_of(samples);
        pieces.push_back(
            {"count.npy",
             npy_header("<u4", {std::uint64_t(samples.height), std::uint64_t(samples.width)}),
             bytes_of(std::span<const std::uint32_t>(counts)),
             {},
             0});
    }
    for (const Channel& channel : samples.channels) {
        if (channel.name == "meta" || channel.name == "count")
            throw Error(
                fmt::format("a channel cannot be called '{}' in an .npz file", channel.name));
        pieces.push_back(piece_of(channel, samples.size()));
    }
    ctx.parallel_for(pieces.size(), [&](size_t i) { finish(pieces[i], deflate); });

    AtomicFile file(path);
    ZipWriter zip(file.temporary());
    for (const ZipPiece& piece : pieces) {
        ctx.check_cancelled();
        zip.add(piece);
    }
    zip.close();
    file.commit();
}

}  // namespace weft
