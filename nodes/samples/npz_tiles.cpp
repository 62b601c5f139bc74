#include "samples/npz_tiles.h"

#include "samples/npy.h"
#include "samples/sample_meta.h"

namespace weft {
namespace {

template <class T>
std::span<const std::uint8_t> bytes_of(std::span<const T> values) {
    return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()};
}

}  // namespace

NpzTiles::NpzTiles(const std::string& path, const Samples& head, std::vector<Member> channels)
    : head_(head), channels_(std::move(channels)), file_(path), zip_(file_.temporary()) {
    const std::uint64_t samples = head_.size();
    for (const Member& c : channels_) {
        std::vector<std::uint64_t> shape{samples};
        if (c.components > 1) shape.push_back(std::uint64_t(c.components));
        members_.push_back(zip_.reserve(c.name + ".npy", npy_header(c.whole ? "<u4" : "<f4", shape),
                                        samples * std::uint64_t(c.components) * 4));
    }
    if (head_.spp == 0)
        members_.push_back(zip_.reserve(
            "count.npy",
            npy_header("<u4", {std::uint64_t(head_.height), std::uint64_t(head_.width)}),
            std::uint64_t(head_.pixels()) * 4));
}

void NpzTiles::write(size_t channel, std::uint64_t first, std::span<const float> values) {
    zip_.write(members_[channel], first * std::uint64_t(channels_[channel].components) * 4,
               bytes_of(values));
}
void NpzTiles::write(size_t channel, std::uint64_t first, std::span<const std::uint32_t> values) {
    zip_.write(members_[channel], first * std::uint64_t(channels_[channel].components) * 4,
               bytes_of(values));
}
void NpzTiles::write_counts(std::uint64_t first_pixel, std::span<const std::uint32_t> counts) {
    zip_.write(members_[channels_.size()], first_pixel * 4, bytes_of(counts));
}

void NpzTiles::close(Context& ctx) {
    ctx.parallel_for(members_.size(), [&](size_t i) { zip_.finish_reserved(members_[i]); });
    const std::string meta = meta_to_write(head_, ctx).dump();
    ZipPiece piece{
        "meta.npy", npy_header("|u1", {meta.size()}), bytes_of(std::span<const char>(meta)), {}, 0};
    finish(piece, false);
    zip_.add(piece);
    zip_.close();
    file_.commit();
}

}  // namespace weft
