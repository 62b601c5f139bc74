// A separable Gaussian over planes: down the columns into a line, then along it. Where the last of
// the planes (1 where a pixel is known, 0 where not) is cut, weights are of what is left.
#pragma once
#include <span>
#include <vector>

#include "filters/planes.h"

namespace weft::kernel {

// exp(-d^2 / (2 sigma^2)) of -radius ... radius; cut at three standard deviations.
std::vector<float> gaussian_taps(float sigma);

// Rows [begin, end) of `count` planes, and of the plane of weights that follows them, into `out`:
// means, and total weights. Where these are 0 the means are 0.
// Cost: 2 taps multiply-adds a value.
namespace v2 {
void gaussian_rows(const Planes& in, int count, std::span<const float> taps, int begin, int end,
                   Planes& out);
}
namespace v3 {
void gaussian_rows(const Planes& in, int count, std::span<const float> taps, int begin, int end,
                   Planes& out);
}
namespace v4 {
void gaussian_rows(const Planes& in, int count, std::span<const float> taps, int begin, int end,
                   Planes& out);
}

}  // namespace weft::kernel
