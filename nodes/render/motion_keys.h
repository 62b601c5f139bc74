// fewest_keys: as few motion keys at equal steps as describe a movement.
//   samples  2^k + 1 places at equal steps over the shutter, k >= 0; or one
//   returns  every 2^j-th of them, such that what lies between two keys (keyed_motion.h) stays
//   within
//            a five-hundredth of the path from every sample; one where nothing moves
#pragma once
#include <vector>

#include "render/scene.h"

namespace weft {

std::vector<Affine> fewest_keys(const std::vector<Affine>& samples);

}  // namespace weft
