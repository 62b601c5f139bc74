#include "samples/zip_writer.h"

#include <fmt/format.h>
#include <libdeflate.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <new>

#include "graph/error.h"

namespace weft {
namespace {

constexpr std::uint16_t fixed_time = 0, fixed_date = (1 << 5) | 1;  // 1980-01-01 00:00
constexpr std::uint64_t alignment = 64;

template <class T>
void append(std::string& to, T value) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void append16(std::string& to, std::uint64_t value) {
    append(to, std::uint16_t(value));
}
void append32(std::string& to, std::uint64_t value) {
    append(to, std::uint32_t(value));
}
void append64(std::string& to, std::uint64_t value) {
    append(to, value);
}

struct Sizes {
    std::uint64_t plain, packed;
};
Sizes sizes_of(const ZipPiece& piece, std::uint64_t data_size) {
    const std::uint64_t plain = piece.head.size() + data_size;
    return {plain, piece.packed.empty() ? plain : piece.packed.size()};
}

}  // namespace

void finish(ZipPiece& piece, bool deflate) {
    piece.crc = libdeflate_crc32(0, piece.head.data(), piece.head.size());
    // Of no bytes at no address, libdeflate gives the checksum's start.
    if (!piece.data.empty())
        piece.crc = libdeflate_crc32(piece.crc, piece.data.data(), piece.data.size());
    piece.packed.clear();
    if (!deflate) return;
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> packer(
        libdeflate_alloc_compressor(6), &libdeflate_free_compressor);
    if (!packer) throw std::bad_alloc();
    std::vector<std::uint8_t> plain(piece.head.begin(), piece.head.end());
    plain.insert(plain.end(), piece.data.begin(), piece.data.end());
    piece.packed.resize(plain.size());
    // 0 if it would not fit, that is, not become smaller.
    piece.packed.resize(libdeflate_deflate_compress(packer.get(), plain.data(), plain.size(),
                                                    piece.packed.data(), piece.packed.size()));
}

ZipWriter::ZipWriter(std::string path, std::uint64_t zip64_from)
    : path_(std::move(path)), file_(std::fopen(path_.c_str(), "w+b")), zip64_from_(zip64_from) {
    if (!file_) fail();
}

ZipWriter::~ZipWriter() {
    if (file_) std::fclose(file_);
}

void ZipWriter::fail() const {
    throw Error(fmt::format("cannot write '{}': {}", path_, std::strerror(errno)));
}

void ZipWriter::put(const void* bytes, std::uint64_t size) {
    if (size && std::fwrite(bytes, 1, size, file_) != size) fail();
    written_ += size;
}

void ZipWriter::add(const ZipPiece& piece) {
    put_member(piece, piece.data.size());
    if (piece.packed.empty()) {
        put(piece.head.data(), piece.head.size());
        put(piece.data.data(), piece.data.size());
    } else {
        put(piece.packed.data(), piece.packed.size());
    }
}

ZipWriter::Reserved ZipWriter::reserve(const std::string& name, const std::string& head,
                                       std::uint64_t size) {
    const ZipPiece piece{name, head, {}, {}, 0};
    Reserved out{written_, 0, size, directory_.size(), head.size()};
    put_member(piece, size);
    put(head.data(), head.size());
    out.data = written_;
    written_ += size;
    if (std::fflush(file_) != 0 || ::ftruncate(::fileno(file_), off_t(written_)) != 0 ||
        ::fseeko(file_, off_t(written_), SEEK_SET) != 0)
        fail();
    return out;
}

void ZipWriter::write(const Reserved& member, std::uint64_t offset,
                      std::span<const std::uint8_t> bytes) {
    if (offset > member.size || bytes.size() > member.size - offset)
        throw Error("a sample file was to hold fewer samples than it is given");
    while (!bytes.empty()) {
        const ssize_t n =
            ::pwrite(::fileno(file_), bytes.data(), bytes.size(), off_t(member.data + offset));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) fail();
        bytes = bytes.subspan(size_t(n));
        offset += std::uint64_t(n);
    }
}

void ZipWriter::finish_reserved(const Reserved& member) {
    std::vector<std::uint8_t> buffer(size_t{1} << 20);
    std::uint32_t crc = 0;
    std::uint64_t at = member.data - member.head;
    const std::uint64_t end = member.data + member.size;
    while (at < end) {
        const ssize_t n =
            ::pread(::fileno(file_), buffer.data(),
                    size_t(std::min<std::uint64_t>(buffer.size(), end - at)), off_t(at));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) fail();
        crc = libdeflate_crc32(crc, buffer.data(), size_t(n));
        at += std::uint64_t(n);
    }
    // After signature, version, flags, method, time and date; of the directory's entry one more
    // version.
    constexpr std::uint64_t in_local = 14, in_directory = 16;
    if (::pwrite(::fileno(file_), &crc, sizeof crc, off_t(member.local + in_local)) != sizeof crc)
        fail();
    std::memcpy(directory_.data() + member.directory + in_directory, &crc, sizeof crc);
}

// The local header and the directory's entry.
void ZipWriter::put_member(const ZipPiece& piece, std::uint64_t data_size) {
    const Sizes sizes = sizes_of(piece, data_size);
    const bool stored = piece.packed.empty();
    const bool large = sizes.plain >= zip64_from_ || sizes.packed >= zip64_from_;
    const std::uint64_t offset = written_;
    const bool far = offset >= zip64_from_;

    std::string extra;
    if (large) {
        append16(extra, 1);
        append16(extra, 16);
        append64(extra, sizes.plain);
        append64(extra, sizes.packed);
    }
    const std::uint64_t bare = offset + 30 + piece.name.size() + extra.size();
    std::uint64_t padding = (alignment - bare % alignment) % alignment;
    if (padding > 0 && padding < 6) padding += alignment;  // the field's own head, and what it says
    if (stored && padding > 0) {
        append16(extra, 0xd935);
        append16(extra, padding - 4);
        append16(extra, alignment);
        extra.append(size_t(padding - 6), '\0');
    }

    // What local and central header share: needed version, flags, method, time, checksum, sizes.
    std::string common;
    append16(common, large || far ? 45 : 20);
    append16(common, 0);
    append16(common, stored ? 0 : 8);
    append16(common, fixed_time);
    append16(common, fixed_date);
    append32(common, piece.crc);
    append32(common, large ? 0xffffffff : sizes.packed);
    append32(common, large ? 0xffffffff : sizes.plain);
    append16(common, piece.name.size());

    std::string local;
    append32(local, 0x04034b50);
    local += common;
    append16(local, extra.size());
    local += piece.name;
    local += extra;
    put(local.data(), local.size());

    std::string wide;  // only what does not fit below, in this order
    if (large) append64(wide, sizes.plain);
    if (large) append64(wide, sizes.packed);
    if (far) append64(wide, offset);
    append32(directory_, 0x02014b50);
    append16(directory_, 45);
    directory_ += common;
    append16(directory_, wide.empty() ? 0 : wide.size() + 4);
    append16(directory_, 0);  // comment
    append16(directory_, 0);  // disk
    append16(directory_, 0);  // internal attributes
    append32(directory_, 0);  // external attributes
    append32(directory_, far ? 0xffffffff : offset);
    directory_ += piece.name;
    if (!wide.empty()) {
        append16(directory_, 1);
        append16(directory_, wide.size());
        directory_ += wide;
    }
    ++members_;
}

void ZipWriter::close() {
    const std::uint64_t offset = written_, size = directory_.size();
    const bool wide = offset >= zip64_from_ || size >= zip64_from_ || members_ >= 0xffff;
    put(directory_.data(), directory_.size());
    std::string end;
    if (wide) {
        append32(end, 0x06064b50);
        append64(end, 44);
        append16(end, 45);
        append16(end, 45);
        append32(end, 0);
        append32(end, 0);
        append64(end, members_);
        append64(end, members_);
        append64(end, size);
        append64(end, offset);
        append32(end, 0x07064b50);
        append32(end, 0);
        append64(end, offset + size);
        append32(end, 1);
    }
    append32(end, 0x06054b50);
    append16(end, 0);
    append16(end, 0);
    append16(end, wide ? 0xffff : members_);
    append16(end, wide ? 0xffff : members_);
    append32(end, wide ? 0xffffffff : size);
    append32(end, wide ? 0xffffffff : offset);
    append16(end, 0);
    put(end.data(), end.size());
    std::FILE* file = file_;
    file_ = nullptr;
    if (std::fclose(file) != 0) fail();
}

}  // namespace weft
