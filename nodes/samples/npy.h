// The .npy form of one array: a header that is a Python literal, then the numbers.
// Source: NumPy enhancement proposal 1 and its versions 2.0, 3.0. Departure: little-endian and C
// order only; f2, f4, f8, u1, u2, u4.
#pragma once
#include <string>
#include <vector>

#include "samples/file_bytes.h"
#include "samples/samples.h"

namespace weft {

class Context;

struct Npy {
    char kind = 0;      // 'f' or 'u'
    int item_size = 0;  // bytes of a number
    std::vector<std::uint64_t> shape;
    std::span<const std::uint8_t> data;  // exactly the product of shape and item_size
    std::uint64_t numbers() const { return data.size() / size_t(item_size); }
};

// Throws Error beginning with `what` ("a.npz: 'xy'") when it is no such array, or one of another
// kind.
Npy parse_npy(std::span<const std::uint8_t> bytes, const std::string& what);

// "(460800, 2)", as numpy writes it.
std::string shape_text(const std::vector<std::uint64_t>& shape);

// The numbers as floats: f4 in place where aligned (`owner` is kept), everything else converted.
Array<float> npy_floats(const Npy& array, const std::shared_ptr<const void>& owner, Context& ctx);

// The numbers as unsigned 32-bit, of a kind 'u' array; u4 in place where aligned.
Array<std::uint32_t> npy_whole(const Npy& array, const std::shared_ptr<const void>& owner,
                               Context& ctx);

// Header of a version 1.0 array, padded so that what follows lies at a multiple of 64.
std::string npy_header(std::string_view descr, const std::vector<std::uint64_t>& shape);

}  // namespace weft
