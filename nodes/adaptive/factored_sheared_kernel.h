// The sheared filter of a lens as two filters of fewer dimensions: over (x, u) along the rows of
// the picture, then over (y, v) along its columns.
//   cells   samples of one row of the picture that lie in one row of the lens: one y, one v
//   pass 1  for each pixel column, the samples of each cell weighted by x and u: sums for each
//           column of the lens (lens_pieces.h), for a round lens does not factor as a whole
//   pass 2  cells weighted by y and v, and summed
// Source: Yan et al. 2015.  Departures: boxes and exact intervals of the lens instead of Gaussians
// (sheared_filter_kernel.h), so that the lens may have any outline; a cell's samples may differ in
// y and v, and have their mean there. Slopes are those of the pixel that a pass writes to: equal
// over the picture, and with cells of one y and one v, the result is the sheared filter's.
// Cost: for n samples in a filter's width and l rows of the lens O(n l) instead of O(n^2 l^2).
#pragma once
#include "adaptive/sheared_filter_kernel.h"

namespace weft::adaptive {

// Samples in cells, from left to right.
class LensCells {
  public:
    // Sample k = j l + i of each pixel, or i l + j, in row j of the lens; Error, as `who`, where
    // the samples are not in that order. `widest`: px, radius of the largest circle of confusion.
    static LensCells of_grid(const Samples& samples, float widest, std::string_view who);
    // In so many rows of equal height, whatever order they come in.
    static LensCells of_any(const Samples& samples, int rows);

    struct Sample {
        float x, y, u, v, stands, rgb[3];  // u, v on the unit disc, aspect taken out
    };
    size_t rows() const { return rows_; }
    // Those of columns [left, right] of the picture.
    std::span<const Sample> in(int y, size_t row, int left, int right) const {
        const size_t cell = (size_t(y) * rows_ + row) * width_;
        const size_t from = first_[cell + size_t(left)], to = first_[cell + size_t(right) + 1];
        return std::span(sorted_).subspan(from, to - from);
    }

  private:
    template <class RowOf>
    LensCells(const Samples& samples, size_t rows, const RowOf& row_of);
    size_t rows_, width_;
    std::vector<std::uint32_t> first_;
    std::vector<Sample> sorted_;
};

// A cell as one pixel column sees it, with the columns of the lens that the pixel's filter has.
struct SeenCell {
    // Of weights in one column of the lens: sums of w, w x, w x^2, w rgb, w rgb x; x from the
    // filter's middle.
    struct Sums {
        std::array<double, 9> of{};
        double w() const { return of[0]; }
        double x() const { return of[1]; }
        double xx() const { return of[2]; }
        double rgb(size_t c) const { return of[3 + c]; }
        double rgb_x(size_t c) const { return of[6 + c]; }
        void add(double weight, const Sums& other) {
            for (size_t k = 0; k < of.size(); ++k) of[k] += weight * other.of[k];
        }
    };
    const LensPieces* pieces = nullptr;
    std::array<Sums, lens_columns> of;        // as many as pieces has
    double w = 0, squares = 0, y = 0, v = 0;  // of the whole width: sums of w, w^2, w y, w v
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
};

class FactoredSheared {
  public:
    // Keeps references.
    FactoredSheared(const Samples& samples, const Image& slopes, const ShearedSettings& settings,
                    const LensCells& cells);
    // Pixels (x, 0), (x, 1) ...; cells: scratch, kept between columns.
    void column(int x, std::vector<SeenCell>& cells, std::span<ShearedFilter::Pixel> out) const;

  private:
    void see(const ShearedFilter::Filter& filter, int y, size_t row, SeenCell& out) const;
    void add(const ShearedFilter::Filter& filter, const SeenCell& cell,
             ShearedFilter::Sums& to) const;

    const Samples& samples_;
    ShearedFilter filter_;
    SlopeReader slopes_;
    const LensCells& cells_;
};

}  // namespace weft::adaptive
