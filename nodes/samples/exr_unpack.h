// Unpacking what OpenEXR packs by RLE or ZIP.
// Source: "OpenEXR File Layout" and its technical introduction: bytes are split into those of even
// and of odd index, then each is stored as the difference to the one before plus 128.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace weft {

enum class ExrPacking { none = 0, rle = 1, zip = 2 };

// Unpacks into `plain`, whose size is what must come out; data as long as that are not packed.
// `scratch` is memory to reuse. False: the data are damaged.
bool exr_unpack(ExrPacking packing, std::span<const std::uint8_t> packed,
                std::span<std::uint8_t> plain, std::vector<std::uint8_t>& scratch);

// The most bytes that `packed` can become.
std::uint64_t exr_unpacked_limit(std::uint64_t packed);

}  // namespace weft
