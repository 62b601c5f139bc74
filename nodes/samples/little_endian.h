// Little-endian numbers at any byte of a span; the caller has seen to the bounds.
#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>

namespace weft {

static_assert(std::endian::native == std::endian::little, "arrays are used as they lie in files");

template <class T>
T number_at(std::span<const std::uint8_t> bytes, size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
}
inline std::uint16_t u16(std::span<const std::uint8_t> b, size_t at) {
    return number_at<std::uint16_t>(b, at);
}
inline std::uint32_t u32(std::span<const std::uint8_t> b, size_t at) {
    return number_at<std::uint32_t>(b, at);
}
inline std::uint64_t u64(std::span<const std::uint8_t> b, size_t at) {
    return number_at<std::uint64_t>(b, at);
}

}  // namespace weft
