// Several axis-aligned filters of a lens: how a sample counts for a pixel whose surroundings have
// one circle of confusion, c. What is seen through the lens at film frequency f has frequency c f
// over it; with that taken off, pixels' means say all of a narrow band of f.
//   bands   their middles f on a square grid of step W / K within W = lens_band / c; round
//           Gaussians of deviation 0.6 W / K
//   sample  a way d px from the pixel, from lens position p: the sum over bands of
//           A(c f) exp(2 pi j f (d + c p)), A the lens's transform, times the Gaussian's own
//           exp(-d^2 / (2 sigma^2)), sigma = 1 / (2 pi 0.6 W / K)
// In units of the lens, d / c + p, the sum is one function for all c: it is kept in a table.
// Source: after Wu et al. 2017; derived here.
#pragma once
#include <vector>

#include "samples/samples.h"

namespace weft::adaptive {

inline constexpr double band_deviation = 0.6;  // in parts of what is between bands' middles

class LensBands {
  public:
    LensBands(int count, const Lens& lens);  // count: K
    // At d / c + p, the lens's aspect taken out.
    float operator()(float x, float y) const;
    float sigma() const { return sigma_; }  // of the Gaussian, in parts of c

  private:
    size_t side_;
    float scale_;  // cells a unit
    float sigma_;
    std::vector<float> table_;  // a period in x and y, and its first row and column again
};

}  // namespace weft::adaptive
