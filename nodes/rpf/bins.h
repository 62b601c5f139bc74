// Numbers sorted into bins, as bits: bin b of a row is a mask with a bit a sample. How many samples fall into a pair
// of bins is then the number of bits that two masks have in common.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace weft::rpf {

inline constexpr size_t most_bins = 10;

// Where one bin ends and the next begins, ascending: bin b holds edge[b - 1] <= x < edge[b].
struct Edges {
    std::array<float, most_bins - 1> edge{};
    size_t bins = 1;
};

struct BinMasks {
    size_t bins = 1, words = 0, samples = 0;
    std::vector<std::uint64_t> bits;                 // bins x words
    std::array<std::uint32_t, most_bins> count{};    // samples of each bin
};

}  // namespace weft::rpf
