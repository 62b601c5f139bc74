#include "samples/exr_unpack.h"

#include <libdeflate.h>

#include <cstring>
#include <memory>
#include <new>

namespace weft {
namespace {

// A count from 0: the next byte, count + 1 times; below 0: -count bytes as they are.
bool unpack_rle(std::span<const std::uint8_t> packed, std::span<std::uint8_t> plain) {
    while (!packed.empty()) {
        const int count = std::int8_t(packed[0]);
        packed = packed.subspan(1);
        const size_t length = count < 0 ? size_t(-count) : size_t(count) + 1;
        const size_t taken = count < 0 ? length : 1;
        if (taken > packed.size() || length > plain.size()) return false;
        if (count < 0)
            std::memcpy(plain.data(), packed.data(), length);
        else
            std::memset(plain.data(), packed[0], length);
        packed = packed.subspan(taken);
        plain = plain.subspan(length);
    }
    return plain.empty();
}

bool unpack_zip(std::span<const std::uint8_t> packed, std::span<std::uint8_t> plain) {
    const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
        inflater(libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
    if (!inflater) throw std::bad_alloc();
    return libdeflate_zlib_decompress(inflater.get(), packed.data(), packed.size(), plain.data(),
                                      plain.size(), nullptr) == LIBDEFLATE_SUCCESS;
}

}  // namespace

bool exr_unpack(ExrPacking packing, std::span<const std::uint8_t> packed,
                std::span<std::uint8_t> plain, std::vector<std::uint8_t>& scratch) {
    if (packed.size() == plain.size()) {
        if (!plain.empty()) std::memcpy(plain.data(), packed.data(), plain.size());
        return true;
    }
    if (packing == ExrPacking::none || packed.size() > plain.size()) return false;
    scratch.resize(plain.size());
    if (!(packing == ExrPacking::rle ? unpack_rle(packed, scratch) : unpack_zip(packed, scratch)))
        return false;
    for (size_t i = 1; i < scratch.size(); ++i)
        scratch[i] = std::uint8_t(scratch[i - 1] + scratch[i] - 128);
    const size_t half = (plain.size() + 1) / 2;
    for (size_t i = 0; i < plain.size(); ++i)
        plain[i] = i % 2 == 0 ? scratch[i / 2] : scratch[half + i / 2];
    return true;
}

std::uint64_t exr_unpacked_limit(std::uint64_t packed) {
    return 1032 * packed;
}

}  // namespace weft
