#include "render/gltf_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/shapes.h"

namespace weft {
namespace {

Vec3 direction(Vec3 v, Vec3 otherwise) {
    const float size = length(v);
    return size > 1e-12f && std::isfinite(size) ? v * (1 / size) : otherwise;
}

std::vector<std::array<std::uint32_t, 3>> triangles(const std::vector<std::uint32_t>& list,
                                                    int mode) {
    std::vector<std::array<std::uint32_t, 3>> all;
    const size_t n = list.size();
    if (mode == TINYGLTF_MODE_TRIANGLES)
        for (size_t i = 0; i + 2 < n; i += 3) all.push_back({list[i], list[i + 1], list[i + 2]});
    else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
        for (size_t i = 0; i + 2 < n; ++i)
            all.push_back({list[i], list[i + 1 + i % 2], list[i + 2 - i % 2]});
    else
        for (size_t i = 1; i + 1 < n; ++i) all.push_back({list[0], list[i], list[i + 1]});
    return all;
}

// The attribute that holds set `set` of texture coordinates; where the mesh lacks it, that is told
// and the first set stands in, if there is one.
std::string uv_attribute(const GltfFile& file, const tinygltf::Primitive& p, int set,
                         const std::string& what, std::vector<std::string>& warnings) {
    std::string wanted = fmt::format("TEXCOORD_{}", set);
    if (p.attributes.count(wanted)) return wanted;
    const bool other = p.attributes.count("TEXCOORD_0");
    warnings.push_back(fmt::format(
        "{}: {}: a texture of its material {} ('{}') reads {}, which it has not; {}", file.path(),
        what, p.material, file.model().materials[size_t(p.material)].name, wanted,
        other ? "TEXCOORD_0 is taken" : "it is one colour all over, the texture's at (0, 0)"));
    return "TEXCOORD_0";
}

}  // namespace

GltfPrimitive gltf_primitive(const GltfFile& file, size_t mesh_index, size_t primitive_index,
                             const std::vector<GltfUvSets>& uv_sets,
                             std::vector<std::string>& warnings) {
    const auto& m = file.model().meshes[mesh_index];
    const auto& p = m.primitives[primitive_index];
    const std::string name = m.name.empty() ? fmt::format("mesh {}", mesh_index) : m.name;
    const std::string what =
        fmt::format("mesh {} ('{}'), primitive {}", mesh_index, m.name, primitive_index);
    GltfPrimitive out;
    out.mesh.name = m.primitives.size() > 1 ? fmt::format("{}.{}", name, primitive_index) : name;
    for (const char* packed : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"})
        if (p.extensions.count(packed))
            file.fail(what,
                      fmt::format("it is compressed ({}), which is not read; export the file again "
                                  "without compression, or unpack it: "
                                  "npx @gltf-transform/cli cp IN OUT",
                                  packed));
    const int mode = p.mode < 0 ? TINYGLTF_MODE_TRIANGLES : p.mode;
    if (mode < TINYGLTF_MODE_POINTS || mode > TINYGLTF_MODE_TRIANGLE_FAN)
        file.fail(what, fmt::format("mode {}; expected 0 to 6", mode));
    if (mode < TINYGLTF_MODE_TRIANGLES) {
        warnings.push_back(fmt::format("{}: {}: points and lines are left out", file.path(), what));
        return out;
    }
    const auto at = p.attributes.find("POSITION");
    if (at == p.attributes.end()) {
        warnings.push_back(fmt::format("{}: {}: no positions; left out", file.path(), what));
        return out;
    }
    out.mesh.positions = file.vectors(at->second, what);
    const size_t count = out.mesh.positions.size();
    const auto same = [&](size_t n, size_t each, const std::string& attribute) {
        if (n != count * each)
            file.fail(what, fmt::format("{} has {} elements for {} positions", attribute, n / each,
                                        count));
    };
    std::vector<std::uint32_t> list;
    if (p.indices >= 0)
        list = file.indices(p.indices, what);
    else
        for (size_t i = 0; i < count; ++i) list.push_back(std::uint32_t(i));
    for (size_t i = 0; i < list.size(); ++i)
        if (list[i] >= count)
            file.fail(what,
                      fmt::format("index {} is {}, there are {} vertices", i, list[i], count));
    out.mesh.triangles = triangles(list, mode);
    out.mesh.material = p.material < 0
                            ? int(uv_sets.size()) - 1
                            : int(file.index(p.material, uv_sets.size() - 1, what, "material"));

    if (const auto n = p.attributes.find("NORMAL"); n != p.attributes.end()) {
        out.mesh.normals = file.vectors(n->second, what);
        same(out.mesh.normals.size(), 1, "NORMAL");
        Mesh made = out.mesh;  // for normals that say nothing
        make_normals(made);
        for (size_t i = 0; i < count; ++i)
            out.mesh.normals[i] = direction(out.mesh.normals[i], made.normals[i]);
    }
    const GltfUvSets& sets = uv_sets[size_t(out.mesh.material)];
    const auto coordinates = [&](const std::string& attribute, std::vector<Vec2>& uv) {
        const auto t = p.attributes.find(attribute);
        if (t == p.attributes.end()) return;
        const std::vector<float> values = file.numbers(t->second, 2, what);
        same(values.size(), 2, attribute);
        for (size_t i = 0; i < count; ++i) uv.push_back({values[2 * i], values[2 * i + 1]});
    };
    if (sets.empty()) coordinates("TEXCOORD_0", out.mesh.uv);  // for another material in its place
    for (size_t i = 0; i < sets.size(); ++i)
        coordinates(uv_attribute(file, p, sets[i], what, warnings),
                    i == 0 ? out.mesh.uv : out.mesh.uv2);
    for (size_t k = 0; k < p.targets.size(); ++k)
        for (const auto& [attribute, accessor] : p.targets[k]) {
            auto* to = attribute == "POSITION" ? &out.morph_positions
                       : attribute == "NORMAL" ? &out.morph_normals
                                               : nullptr;
            if (!to) continue;
            to->resize(p.targets.size());
            (*to)[k] = file.vectors(accessor, fmt::format("{}, morph target {}", what, k));
            same((*to)[k].size(), 1, fmt::format("{} of morph target {}", attribute, k));
        }
    const auto joints = p.attributes.find("JOINTS_0"), weights = p.attributes.find("WEIGHTS_0");
    if (joints != p.attributes.end() && weights != p.attributes.end()) {
        out.joints = file.numbers(joints->second, 4, what);
        out.weights = file.numbers(weights->second, 4, what);
        same(out.joints.size(), 4, "JOINTS_0");
        same(out.weights.size(), 4, "WEIGHTS_0");
        if (p.attributes.count("JOINTS_1"))
            warnings.push_back(
                fmt::format("{}: {}: more than four joints a vertex; the others are left out",
                            file.path(), what));
    }
    return out;
}

Mesh posed(const GltfFile& file, const GltfPrimitive& primitive,
           const std::vector<std::vector<float>>& weights,
           const std::vector<std::vector<Affine>>& joints, const std::string& element) {
    const size_t count = primitive.mesh.positions.size();
    Mesh mesh = primitive.mesh;
    mesh.positions.clear(), mesh.normals.clear();
    mesh.steps = int(weights.size());
    const bool normals = !primitive.mesh.normals.empty();
    const bool skinned = !primitive.joints.empty() && !joints.front().empty();
    for (size_t key = 0; key < weights.size(); ++key)
        for (size_t v = 0; v < count; ++v) {
            Vec3 p = primitive.mesh.positions[v];
            Vec3 n = normals ? primitive.mesh.normals[v] : Vec3{};
            const auto morph = [&](const std::vector<std::vector<Vec3>>& targets, Vec3& value) {
                for (size_t k = 0; k < std::min(targets.size(), weights[key].size()); ++k)
                    if (!targets[k].empty()) value += targets[k][v] * weights[key][k];
            };
            morph(primitive.morph_positions, p);
            if (normals) morph(primitive.morph_normals, n);
            if (skinned) {
                Vec3 to{}, turned{};
                float total = 0;
                for (size_t j = 4 * v; j < 4 * v + 4; ++j) {
                    const float w = primitive.weights[j];
                    if (!(w > 0)) continue;
                    const float joint = primitive.joints[j];
                    if (!(joint >= 0) || joint >= float(joints[key].size()))
                        file.fail(element, fmt::format("vertex {} names joint {} of {}", v, joint,
                                                       joints[key].size()));
                    const Affine& m = joints[key][size_t(joint)];
                    const Affine cofactors{cross(m.y, m.z), cross(m.z, m.x), cross(m.x, m.y), {}};
                    to += m.point(p) * w;
                    turned += direction(cofactors.vector(n), n) * w;
                    total += w;
                }
                if (total > 0) p = to * (1 / total), n = turned;
            }
            if (!finite(p))
                file.fail(element, fmt::format("vertex {} is moved out of all bounds", v));
            mesh.positions.push_back(p);
            if (normals) mesh.normals.push_back(direction(n, primitive.mesh.normals[v]));
        }
    // Keys that are all alike are one.
    if (mesh.steps > 1 && std::equal(mesh.positions.begin() + std::ptrdiff_t(count),
                                     mesh.positions.end(), mesh.positions.begin())) {
        mesh.steps = 1;
        mesh.positions.resize(count);
        if (normals) mesh.normals.resize(count);
    }
    return mesh;
}

}  // namespace weft
