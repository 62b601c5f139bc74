// Leaves, wings, trunks and their textures, for the procedural scenes.
#pragma once
#include "render/scene_builder.h"

namespace weft {

// From its stalk at the origin along +x to (1, 0, 0), lying in x and z, a little folded and bent.
Mesh leaf_mesh(float width, float fold, float bend);
// A butterfly's right pair of wings: the root along z from -0.5 to 0.4, out to x = 1, ahead is -z.
Mesh wing_mesh();

// Light grey with veins, to be multiplied by a leaf's colour.
int leaf_texture(SceneBuilder& build);
// A wing in `color` with dark veins and margin and light spots.
int wing_texture(SceneBuilder& build, const std::string& name, Vec3 color, Vec3 spots);
int bark_texture(SceneBuilder& build, std::uint64_t seed);

}  // namespace weft
