// Mutual information of two rows of numbers from their joint histogram: how far one tells of the other, in nats; 0 where
// they are independent.
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

// Edges of the bins of a normalised row whose numbers lie in [low, high]. A row of one value has one bin.
Edges find_edges(const float* row, size_t n, float low, float high, Binning binning, size_t bins, std::vector<float>& scratch);

class MutualInformation {
  public:
    explicit MutualInformation(Correction correction = Correction::none) : correction_(correction) {}
    double operator()(const BinMasks& x, const BinMasks& y);

  private:
    std::int64_t n_log_n(size_t n);
    double raw(const BinMasks& x, const BinMasks& y, size_t& occupied);

    Correction correction_;
    std::vector<std::int64_t> table_;
    BinMasks shifted_;
};

}  // namespace weft::rpf
