// Scenes made by rule, which need no file.
//   seed   another arrangement of the same scene
//   size   how much there is in it: 1 as meant; counts of things grow with it
// The same seed and size give the same scene.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "render/scene.h"

namespace weft {

// Autumn leaves and butterflies in the air of a wood, over all depths.
Scene leaves_scene(std::uint64_t seed, float size);
// A game of chess, seen from close by with a wide lens; a bishop is being moved.
Scene chess_scene(std::uint64_t seed, float size);
// Wheels, fans, balls and dice, fast and spinning, in front of a painted wall.
Scene motion_scene(std::uint64_t seed, float size);
// A leafy tree and a fence under an area light: soft shadows of many small things.
Scene occluders_scene(std::uint64_t seed, float size);
// A box with a red and a green wall, a metal block and a glass ball.
Scene cornell_scene(std::uint64_t seed, float size);

const std::vector<std::string>& procedural_scene_names();
// One of these by name; Error with the names that there are.
Scene procedural_scene(std::string_view name, std::uint64_t seed = 1, float size = 1);

}  // namespace weft
