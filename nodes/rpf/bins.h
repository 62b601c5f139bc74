// Rows of numbers sorted into bins, as bits: of each row a column a bin, but for the last, as what
// lies in none of the others lies there. How many samples fall into a pair of bins is then the
// number of bits that two columns share.
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

struct BinnedRows {
    static constexpr size_t padding = 8;  // words past the end that may be read

    struct Row {
        Edges edges;
        size_t first = 0;                              // its first column
        std::array<std::uint32_t, most_bins> count{};  // samples of each bin

        size_t bins() const { return edges.bins; }
    };
    std::vector<Row> rows;
    size_t samples = 0, words = 0;    // a word holds 64 samples
    size_t pitch = 0;                 // from word to word: the columns of all rows lie side by side
    std::vector<std::uint64_t> bits;  // words x pitch, and padding
    std::vector<std::uint32_t> counts;  // of columns, and padding
    std::vector<float> scratch;

    const std::uint64_t* column(size_t i) const { return &bits[i]; }
    // One past the last column of a row.
    size_t end(size_t row) const { return rows[row].first + rows[row].bins() - 1; }
};

}  // namespace weft::rpf
