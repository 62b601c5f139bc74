// Writing zip files whose stored members can be mapped: a member's numbers start at a multiple
// of 64. Dates are fixed (1980-01-01), so the same members give the same bytes; zip64 where sizes
// ask for it. Source: PKWARE APPNOTE 6.3.9; the padding stands in an extra field (0xd935) of the
// local header.
#pragma once
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

namespace weft {

// What a member will hold: `head` (a multiple of 64 long, for the alignment to mean something),
// then `data`. `packed` is both, deflated; empty: the member is stored.
struct ZipPiece {
    std::string name;
    std::string head;
    std::span<const std::uint8_t> data;
    std::vector<std::uint8_t> packed;
    std::uint32_t crc = 0;
};

// Fills in crc, and packed where `deflate` is set and it makes the member smaller. Pieces are
// independent: several may be finished at once.
void finish(ZipPiece& piece, bool deflate);

class ZipWriter {
  public:
    // Writes to `path`. Sizes and offsets from `zip64_from` are written as 64-bit numbers (tests
    // lower it).
    explicit ZipWriter(std::string path, std::uint64_t zip64_from = 0xffffffff);
    ~ZipWriter();
    ZipWriter(const ZipWriter&) = delete;
    ZipWriter& operator=(const ZipWriter&) = delete;

    void add(const ZipPiece& piece);

    // A stored member whose numbers are written later, in any order: room for `size` bytes after
    // `head`. write() may be called by several threads at once; finish_reserved() makes its
    // checksum, once all is written and before close().
    struct Reserved {
        std::uint64_t local, data, size, directory;  // where they lie
        std::uint64_t head;                          // length
    };
    Reserved reserve(const std::string& name, const std::string& head, std::uint64_t size);
    void write(const Reserved& member, std::uint64_t offset, std::span<const std::uint8_t> bytes);
    void finish_reserved(const Reserved& member);
    void close();  // the directory; throws Error if anything could not be written

  private:
    void put_member(const ZipPiece& piece, std::uint64_t data_size);
    void put(const void* bytes, std::uint64_t size);
    [[noreturn]] void fail() const;

    std::string path_;
    std::FILE* file_ = nullptr;
    std::uint64_t zip64_from_;
    std::uint64_t written_ = 0, members_ = 0;
    std::string directory_;
};

}  // namespace weft
