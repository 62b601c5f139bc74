// Wavefront OBJ with its MTL -> Scene: a mesh a material. Polygons are cut into triangles; where
// the file has no normals they are made within its smoothing groups. y is up.
//   materials  Kd, map_Kd, Ke, map_Ke, Ks and Ns as a gloss, Pr, Pm, d as thin glass, map_d as a
//              cutout, norm, map_Bump with -bm
#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <tuple>
#include <unordered_map>

#include "graph/error.h"
#include "image/picture_file.h"
#include "render/affine.h"
#include "render/file_there.h"
#include "render/polygon.h"
#include "render/scene_file.h"
#include "samples/random.h"

namespace weft {
namespace {

std::string slashes(std::string path) {
    std::replace(path.begin(), path.end(), '\\', '/');
    return path;
}

// Reads .mtl files beside the scene; a missing one is told and done without.
class MaterialFiles final : public tinyobj::MaterialReader {
  public:
    MaterialFiles(std::filesystem::path folder, std::vector<std::string>& warnings)
        : folder_(std::move(folder)), warnings_(warnings) {}
    bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                    std::map<std::string, int>* numbers, std::string* warning,
                    std::string* error) override {
        const auto path = folder_ / slashes(name);
        if (!file_there(path)) {
            warnings_.push_back(
                fmt::format("{}: no such file; its materials are plain", path.string()));
            return false;
        }
        std::istringstream text(read_whole_file(path.string()));
        tinyobj::LoadMtl(numbers, materials, &text, warning, error);
        return true;
    }

  private:
    std::filesystem::path folder_;
    std::vector<std::string>& warnings_;
};

float part(float v, float fallback) {
    return std::isfinite(v) ? std::clamp(v, 0.0f, 1.0f) : fallback;
}
Vec3 color(const float* c) {
    return {part(c[0], 0), part(c[1], 0), part(c[2], 0)};
}

struct Corner {
    int vertex, uv;
    std::int64_t normal;  // of the file: 0 and up; made in a smoothing group or for one face: below
    bool operator==(const Corner&) const = default;
};
struct CornerHash {
    size_t operator()(const Corner& c) const {
        return mix(mix(std::uint64_t(c.vertex) << 32 | std::uint32_t(c.uv)) +
                   std::uint64_t(c.normal));
    }
};

class Reader {
  public:
    Reader(const std::string& path, std::vector<std::string>& warnings)
        : path_(path), folder_(std::filesystem::path(path).parent_path()), warnings_(warnings) {}

    Scene scene(const std::string& bytes) {
        std::istringstream text(bytes);
        MaterialFiles files(folder_, warnings_);
        std::string warning, error;
        bool good = false;
        try {
            good = tinyobj::LoadObj(&attributes_, &shapes_, &materials_, &warning, &error, &text,
                                    &files, false, false);
        } catch (const std::exception& e) {
            error = e.what();
        }
        std::replace(error.begin(), error.end(), '\n', ' ');
        while (!error.empty() && error.back() == ' ') error.pop_back();
        if (!good)
            throw Error(
                fmt::format("{}: not an OBJ file: {}", path_, error.empty() ? "damaged" : error));
        check_numbers();
        for (const auto& m : materials_) scene_.materials.push_back(material(m));
        Material plain;
        plain.name = "without material";
        scene_.materials.push_back(plain);
        const int last = int(scene_.materials.size()) - 1;
        for (int m = 0; m <= last; ++m) add_mesh(m, last);
        if (scene_.instances.empty())
            throw Error(fmt::format("{}: nothing to see: it has no faces", path_));
        scene_.name = scene_.source = path_;
        return std::move(scene_);
    }

  private:
    void check_numbers() const {
        const auto finite_all = [&](const std::vector<float>& list, size_t each, const char* what) {
            for (size_t i = 0; i < list.size(); ++i)
                if (!std::isfinite(list[i]))
                    throw Error(fmt::format("{}: {} {} is not finite", path_, what, i / each + 1));
        };
        finite_all(attributes_.vertices, 3, "vertex");
        finite_all(attributes_.normals, 3, "normal");
        finite_all(attributes_.texcoords, 2, "texture coordinate");
        for (const auto& shape : shapes_) {
            size_t corners = 0;
            for (const unsigned char n : shape.mesh.num_face_vertices) corners += n;
            if (corners != shape.mesh.indices.size())
                throw Error(
                    fmt::format("{}: group '{}': a face has more than 255 corners; cut it into "
                                "smaller ones",
                                path_, shape.name));
        }
    }

    Material material(const tinyobj::material_t& m) {
        Material out;
        out.name = m.name;
        out.base_color = color(m.diffuse);
        out.base_color_map = map(m.diffuse_texname, m.diffuse_texopt, true, m.name);
        // A picture is meant as it is where its factor is black.
        if (out.base_color_map.used() && out.base_color == Vec3{}) out.base_color = {1, 1, 1};
        out.emission = {std::max(0.0f, std::isfinite(m.emission[0]) ? m.emission[0] : 0),
                        std::max(0.0f, std::isfinite(m.emission[1]) ? m.emission[1] : 0),
                        std::max(0.0f, std::isfinite(m.emission[2]) ? m.emission[2] : 0)};
        out.emission_map = map(m.emissive_texname, m.emissive_texopt, true, m.name);
        const Vec3 shine = color(m.specular);
        const float ns = std::isfinite(m.shininess) ? std::clamp(m.shininess, 0.0f, 1e6f) : 0;
        // Blinn's exponent as GGX: alpha^2 = 2 / (Ns + 2) (Walter et al. 2007, Sec. 5.2).
        if (std::max({shine.x, shine.y, shine.z}) > 0.01f && ns > 1)
            out.roughness = std::clamp(std::pow(2 / (ns + 2), 0.25f), 0.05f, 1.0f);
        else
            out.kind = Material::Kind::diffuse;
        if (m.roughness > 0 || m.metallic > 0) {
            out.kind = Material::Kind::metallic_roughness;
            out.roughness = part(m.roughness, 1), out.metallic = part(m.metallic, 0);
        }
        if (m.ior >= 1 && m.ior <= 10) out.ior = m.ior;
        if (out.ior < 1.05f) out.ior = 1.5f;
        if (!m.alpha_texname.empty()) {
            out.alpha = Material::Alpha::mask;
            out.alpha_map = map(m.alpha_texname, m.alpha_texopt, false, m.name);
        }
        // A picture with alpha is a cutout, whether or not map_d says so.
        if (!out.alpha_map.used() && out.base_color_map.used() && has_alpha(out.base_color_map)) {
            out.alpha = Material::Alpha::mask;
            out.alpha_map = out.base_color_map;
        }
        const float opaque = part(m.dissolve, 1);
        if (opaque < 0.999f && !out.alpha_map.used()) {
            out.kind = Material::Kind::metallic_roughness;
            out.transmission = 1 - opaque;
            out.base_color = lerp({1, 1, 1}, out.base_color, opaque);
            out.roughness = 0;  // seen through, not a frosted pane
        }
        out.normal_map = map(m.normal_texname, m.normal_texopt, false, m.name);
        const float bump = m.bump_texopt.bump_multiplier;
        if (!out.normal_map.used() && bump != 0)
            out.normal_map = map(m.bump_texname, m.bump_texopt, false, m.name,
                                 std::isfinite(bump) ? std::clamp(bump, -1e3f, 1e3f) : 1);
        return out;
    }

    bool has_alpha(const TextureMap& map) const {
        const std::string& path = scene_.textures[size_t(map.file)].path;
        if (!path.ends_with(".png") && !path.ends_with(".PNG")) return false;
        try {
            const auto channels = picture_info(path).channels;
            return std::find(channels.begin(), channels.end(), "A") != channels.end();
        } catch (const Error&) {
            return false;  // told when its pixels are read
        }
    }

    TextureMap map(const std::string& name, const tinyobj::texture_option_t& how, bool is_color,
                   const std::string& material, float bump = 0) {
        TextureMap out;
        if (name.empty()) return out;
        const std::string path = (folder_ / slashes(name)).string();
        if (!file_there(path)) {
            warnings_.push_back(
                fmt::format("{}: material '{}': no picture '{}'; left out", path_, material, name));
            return out;
        }
        const auto [known, fresh] =
            textures_.try_emplace({path, is_color, bump}, int(scene_.textures.size()));
        if (fresh) scene_.textures.push_back({path, nullptr, is_color, bump});
        out.file = known->second;
        const auto number = [](float v, float fallback) { return std::isfinite(v) ? v : fallback; };
        const float su = number(how.scale[0], 1), sv = number(how.scale[1], 1);
        // The file's v runs upwards.
        out.scale = {su, sv};
        out.offset = {number(how.origin_offset[0], 0), 1 - sv - number(how.origin_offset[1], 0)};
        if (how.clamp) out.wrap_u = out.wrap_v = TextureMap::Wrap::clamp;
        return out;
    }

    Vec3 position(int i) const {
        const float* p = attributes_.vertices.data() + 3 * size_t(i);
        return {p[0], p[1], p[2]};
    }

    void require(int i, size_t count, bool optional, const char* what, const std::string& group,
                 size_t face) const {
        if ((optional && i == -1) || (i >= 0 && size_t(i) < count)) return;
        throw Error(fmt::format("{}: group '{}', face {}: {} {} of {}", path_, group, face + 1,
                                what, std::int64_t(i) + 1, count));
    }

    void add_mesh(int number, int without) {
        Mesh mesh;
        mesh.material = number;
        mesh.name = scene_.materials[size_t(number)].name;
        std::unordered_map<Corner, std::uint32_t, CornerHash> known;
        std::unordered_map<Corner, Vec3, CornerHash> made;  // by vertex and smoothing group
        std::vector<Corner> corners;
        bool any_uv = false, any_smooth = false;
        std::int64_t faces = 0;
        for (const auto& shape : shapes_) {
            size_t first = 0;
            for (size_t f = 0; f < shape.mesh.num_face_vertices.size(); ++f) {
                const size_t n = shape.mesh.num_face_vertices[f], begin = first;
                first += n;
                ++faces;
                const int id = f < shape.mesh.material_ids.size() ? shape.mesh.material_ids[f] : -1;
                if ((id >= 0 && id < without ? id : without) != number || n < 3) continue;
                std::vector<Vec3> points;
                std::vector<Corner> around;
                const unsigned group = f < shape.mesh.smoothing_group_ids.size()
                                           ? shape.mesh.smoothing_group_ids[f]
                                           : 0;
                for (size_t k = begin; k < first; ++k) {
                    const tinyobj::index_t& i = shape.mesh.indices[k];
                    require(i.vertex_index, attributes_.vertices.size() / 3, false, "vertex",
                            shape.name, f);
                    require(i.texcoord_index, attributes_.texcoords.size() / 2, true,
                            "texture coordinate", shape.name, f);
                    require(i.normal_index, attributes_.normals.size() / 3, true, "normal",
                            shape.name, f);
                    points.push_back(position(i.vertex_index));
                    const std::int64_t normal = i.normal_index >= 0 ? i.normal_index
                                                : group > 0         ? -2 - std::int64_t(group)
                                                            : -(std::int64_t(1) << 40) - faces;
                    around.push_back({i.vertex_index, i.texcoord_index, normal});
                    any_uv |= i.texcoord_index >= 0;
                    any_smooth |= i.normal_index >= 0 || group > 0;
                }
                Vec3 area{};
                for (size_t k = 0; k < n; ++k)
                    area += cross(points[k] - points[0], points[(k + 1) % n] - points[0]);
                for (const Corner& c : around)
                    if (c.normal < 0) made[{c.vertex, -1, c.normal}] += area;
                for (const auto& t : triangulated(points)) {
                    std::array<std::uint32_t, 3> triangle{};
                    for (size_t k = 0; k < 3; ++k) {
                        const Corner& c = around[size_t(t[k])];
                        const auto [at, fresh] =
                            known.try_emplace(c, std::uint32_t(corners.size()));
                        if (fresh) corners.push_back(c);
                        triangle[k] = at->second;
                    }
                    mesh.triangles.push_back(triangle);
                }
            }
        }
        if (mesh.triangles.empty()) return;
        for (const Corner& c : corners) {
            mesh.positions.push_back(position(c.vertex));
            if (any_uv) {
                const float* uv =
                    c.uv >= 0 ? attributes_.texcoords.data() + 2 * size_t(c.uv) : nullptr;
                mesh.uv.push_back(uv ? Vec2{uv[0], 1 - uv[1]} : Vec2{});
            }
            if (!any_smooth) continue;
            Vec3 normal;
            if (c.normal >= 0) {
                const float* p = attributes_.normals.data() + 3 * size_t(c.normal);
                normal = {p[0], p[1], p[2]};
            } else {
                normal = made[{c.vertex, -1, c.normal}];
            }
            const float size = length(normal);
            mesh.normals.push_back(size > 1e-20f && std::isfinite(size) ? normal * (1 / size)
                                                                        : Vec3{0, 1, 0});
        }
        Instance instance;
        instance.name = mesh.name;
        instance.mesh = int(scene_.meshes.size());
        instance.id = std::uint32_t(scene_.instances.size() + 1);
        scene_.meshes.push_back(std::move(mesh));
        scene_.instances.push_back(std::move(instance));
    }

    const std::string& path_;
    std::filesystem::path folder_;
    std::vector<std::string>& warnings_;
    tinyobj::attrib_t attributes_;
    std::vector<tinyobj::shape_t> shapes_;
    std::vector<tinyobj::material_t> materials_;
    Scene scene_;
    std::map<std::tuple<std::string, bool, float>, int> textures_;
};

}  // namespace

Scene obj_scene(const std::string& bytes, const std::string& path, const SceneOptions& options,
                std::vector<std::string>& warnings) {
    Scene scene = Reader(path, warnings).scene(bytes);
    if (!options.camera.empty())
        throw Error(fmt::format(
            "{}: camera '{}': an OBJ file has no cameras; a JSON scene (docs/scenes.md) "
            "can add one",
            path, options.camera));
    warnings.push_back(fmt::format("{}: it has no camera; one that sees all of it is taken", path));
    scene.camera = camera_around(scene);
    return scene;
}

}  // namespace weft
