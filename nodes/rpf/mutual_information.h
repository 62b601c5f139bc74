// Mutual information of rows of numbers from their joint histograms: how far one tells of the
// other, in nats; 0 where they are independent.
//   I = sum over cells n_xy / N ln(n_xy N / (n_x n_y))
// Sums are of whole numbers (n ln n in steps of 2^-32), so that their order does not matter.
// Source: Sen and Darabi 2012, Sec. 3.2 (histograms); Miller 1955 (bias).
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "rpf/bins.h"

namespace weft::rpf {

enum class Binning {
    centered,  // bins one deviation wide around -2 ... 2 (for five), the outer ones open
    spanned,   // bins one deviation wide over the whole range; more than ten are fitted into ten
    rank,      // bins of equal numbers of samples
};
enum class Correction {
    none,
    miller_madow,  // by occupied cells
    asymptotic,    // by all cells of occupied rows and columns
    shuffle,       // by what is left when one row is shifted against the other
};

// Numbers, readable to whole vectors, that are normalised by (x - mean) scale and then lie in
// [low, high].
struct NumberRow {
    const float* numbers;
    float low, high;
    float mean = 0, scale = 1;
};

// The bins of rows of n numbers. A row of one value has one bin.
void sort_rows(std::span<const NumberRow> rows, size_t n, Binning binning, size_t bins,
               BinnedRows& sorted);

class MutualInformation {
  public:
    struct Range {
        size_t begin, end;  // rows
        size_t size() const { return end - begin; }
    };
    explicit MutualInformation(Correction correction = Correction::none)
        : correction_(correction) {}
    // Of each row of x with each of y, those of y side by side.
    void operator()(const BinnedRows& rows, Range x, Range y, std::vector<double>& information);

  private:
    // What the sums of a row's own bins come to.
    struct Margin {
        std::int64_t n_log_n;
        size_t occupied;
    };
    void grow_table(size_t n);
    Margin margin_of(const BinnedRows::Row& row) const;
    void count(const BinnedRows& x, Range of_x, const BinnedRows& y, Range of_y);

    Correction correction_;
    std::vector<std::int64_t> table_;    // n ln n
    std::vector<std::uint32_t> counts_;  // of columns
    size_t pitch_ = 0;
    std::vector<Margin> margins_;
    BinnedRows shifted_;
};

}  // namespace weft::rpf
