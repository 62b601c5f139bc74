// Meshes of a glTF document: a triangle mesh a primitive; morphed and skinned at given times.
#pragma once
#include <string>
#include <vector>

#include "render/gltf_file.h"
#include "render/gltf_materials.h"

namespace weft {

struct GltfPrimitive {
    Mesh mesh;  // one key, unmorphed; its material is the file's or the one past the last
    std::vector<std::vector<Vec3>> morph_positions, morph_normals;  // a target each; or empty
    std::vector<float> joints, weights;                             // vertices x 4, or empty
};

// The primitive without points and lines; no triangles: there is nothing to see.
//   uv_sets  of each material, as add_gltf_materials() returns them
GltfPrimitive gltf_primitive(const GltfFile& file, size_t mesh, size_t primitive,
                             const std::vector<GltfUvSets>& uv_sets,
                             std::vector<std::string>& warnings);

// Its mesh with a key for every element of `weights` and `joints`.
//   weights  how much of each morph target, a list a key
//   joints   mesh space -> where each joint takes it, a list a key; empty lists: no skin
Mesh posed(const GltfFile& file, const GltfPrimitive& primitive,
           const std::vector<std::vector<float>>& weights,
           const std::vector<std::vector<Affine>>& joints, const std::string& element);

}  // namespace weft
