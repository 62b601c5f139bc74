// Materials and textures of a glTF document.
#pragma once
#include <string>
#include <vector>

#include "render/gltf_file.h"

namespace weft {

// Which sets of texture coordinates (TEXCOORD_n) a material's textures read: those that go to a
// mesh's `uv` and `uv2`; none where it has no texture.
using GltfUvSets = std::vector<int>;

// Adds every material of the file to the scene, then the one that primitives without have; index i
// of the file is index i here.
//   returns  the sets that each reads
std::vector<GltfUvSets> add_gltf_materials(const GltfFile& file, Scene& scene,
                                           std::vector<std::string>& warnings);

}  // namespace weft
