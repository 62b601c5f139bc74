// The parts of building a Hierarchy, as plain functions.
//   recentred   samples -> homogeneous positions at lens centre and half time
//   sort_keys   where each sample goes: block of the picture, then slope and velocity, then place
//   sorted      the order of ascending keys, equal ones as they were
//   bound       groups and rectangles of a hierarchy whose samples are in place
// Source: Lehtinen et al. 2011, Sec. 3.2 and Appendix A (see hierarchy.h).
// Cost: linear in samples but for the sort, which is a radix sort.  Threads: through the context.
#pragma once
#include <cstdint>
#include <vector>

#include "light-field/hierarchy.h"
#include "runtime/context.h"

namespace weft::light_field {

// Homogeneous depth that stands for infinity: far enough that its slope is C1 to the last bit.
inline constexpr float far_depth = 0x1p+40f;

// Radius of the largest empty disk that a good sampling pattern of this density leaves, px.
// Source: 2.2 / sqrt(spp + 0.2) is within 10 % of what the authors of the method measured, from 1 to 256
// samples a pixel.
float dispersion_radius(double samples_per_pixel);

struct Recentred {
    float X, Y, W, VX, VY, VW;
};
// Of sample i. A sample at infinity becomes a point far_depth away.
Recentred recentred(const Samples& samples, size_t i);

// Whether the sample is in front of the camera during the whole shutter.
inline bool always_there(float W, float VW) {
    const float half = 0.5f * (VW < 0 ? -VW : VW);
    return W - half > 1e-6f * half && W > 0;
}

enum class Arrangement {
    layers,  // blocks of about 48 samples along a Morton curve, each sorted by slope and velocity
    cells,   // uniform square cells of about 16 samples, row by row, depth left out of account
};
std::vector<std::uint64_t> sort_keys(const Hierarchy& unsorted, Arrangement arrangement, Context& ctx);
std::vector<std::uint32_t> sorted(std::vector<std::uint64_t>& keys, Context& ctx);

// Everything: `samples` with xy, z and rgb at least.
Hierarchy build_hierarchy(const Samples& samples, Arrangement arrangement, double radius_scale, Context& ctx);

void bound(Hierarchy& hierarchy, Context& ctx);

}  // namespace weft::light_field
