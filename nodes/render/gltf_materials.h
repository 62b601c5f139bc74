// Materials and textures of a glTF document.
#pragma once
#include <string>
#include <vector>

#include "render/gltf_file.h"

namespace weft {

// Adds every material of the file to the scene, then the one that primitives without have; index i
// of the file is index i here.
//   returns  which set of texture coordinates each material reads
std::vector<int> add_gltf_materials(const GltfFile& file, Scene& scene,
                                    std::vector<std::string>& warnings);

}  // namespace weft
