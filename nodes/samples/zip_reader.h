// Reading zip files: the members, and a member's bytes. Stored and deflate members, zip64; no
// encryption, no second disk. Sizes are believed only as far as the file itself bears them out, so
// that a damaged or hostile file never makes us allocate more than about a thousand times its size.
// Source: PKWARE APPNOTE 6.3.9, sections 4.3 to 4.5; inflating and checksums: libdeflate.
#pragma once
#include <string>
#include <vector>

#include "samples/file_bytes.h"

namespace weft {

struct ZipMember {
    std::string name;
    int method = 0;  // 0: stored, 8: deflate
    std::uint32_t crc = 0;
    std::uint64_t size = 0;                // unpacked
    std::span<const std::uint8_t> packed;  // where it lies in the file
};

// All members in directory order. Throws Error naming the file and what is wrong with it.
std::vector<ZipMember> zip_members(const FileBytes& file);

// A member's bytes, checked against its CRC-32: in place where stored, else inflated into memory
// that starts at a multiple of 16.
FileBytes zip_bytes(const FileBytes& file, const ZipMember& member);

}  // namespace weft
