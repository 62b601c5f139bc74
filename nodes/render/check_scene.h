// check_scene: throws Error naming the first thing that a renderer could not trust: an index past
// its list, a number that is not finite, a normal that is not unit, motion keys of unlike count, a
// material or lens out of range. Every scene passes it once, where it is made.
#pragma once
#include "render/scene.h"

namespace weft {

void check_scene(const Scene& scene);

}  // namespace weft
