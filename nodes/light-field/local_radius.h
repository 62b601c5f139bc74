// The radius R where the samples' density varies over the picture: adaptive buffers, irregular
// ones, holes.
#pragma once
#include <vector>

#include "light-field/streams.h"
#include "runtime/context.h"

namespace weft::light_field {

// `scale` times R of each pixel, by the density of the samples in the smallest square around it
// that holds a disk of that radius; empty where it is the same everywhere, within a tenth. From the
// number of samples of each pixel: a location's R does not depend on how they lie.
std::vector<float> local_radii(const Samples& samples, double scale, Context& ctx);

// The largest R of a batch's locations.
float largest_radius(const Hierarchy& hierarchy, const Locations& at);

// Leaves each location those candidates that are within `scale` times its own R, and says in
// Candidates::ratio how that R compares with the hierarchy's. Nothing to do where R is one
// everywhere.
void narrow(float scale, const Locations& at, Candidates& candidates);

}  // namespace weft::light_field
