#include "render/gltf_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "render/file_there.h"

namespace weft {
namespace {

using tinygltf::ExtensionMap;
using tinygltf::Value;

const Value* member(const Value& object, const char* key) {
    return object.IsObject() && object.Has(key) ? &object.Get(key) : nullptr;
}
const Value* extension(const ExtensionMap& all, const char* name) {
    const auto found = all.find(name);
    return found != all.end() && found->second.IsObject() ? &found->second : nullptr;
}
float number(const Value& object, const char* key, float fallback) {
    const Value* v = member(object, key);
    return v && v->IsNumber() ? float(v->GetNumberAsDouble()) : fallback;
}
int whole(const Value& object, const char* key, int fallback) {
    const Value* v = member(object, key);
    if (!v || !v->IsNumber()) return fallback;
    const double number = v->GetNumberAsDouble();
    return number >= -1e9 && number <= 1e9 ? int(number) : -1;
}
std::vector<float> numbers(const Value& object, const char* key) {
    std::vector<float> all;
    if (const Value* v = member(object, key); v && v->IsArray())
        for (size_t i = 0; i < v->ArrayLen(); ++i)
            if (const Value& item = v->Get(int(i)); item.IsNumber())
                all.push_back(float(item.GetNumberAsDouble()));
    return all;
}

float clamped(double v, double low, double high, double fallback) {
    return float(std::isfinite(v) ? std::clamp(v, low, high) : fallback);
}

class Reader {
  public:
    Reader(const GltfFile& file, Scene& scene, std::vector<std::string>& warnings)
        : file_(file), model_(file.model()), scene_(scene), warnings_(warnings) {}

    // The material, and the sets of texture coordinates that it reads.
    Material material(const tinygltf::Material& m, size_t i, GltfUvSets& sets) {
        what_ = m.name.empty() ? fmt::format("material {}", i)
                               : fmt::format("material {} ('{}')", i, m.name);
        sets_.clear();
        Material out;
        out.name = m.name.empty() ? fmt::format("material {}", i) : m.name;
        const auto& pbr = m.pbrMetallicRoughness;
        color(pbr.baseColorFactor, out);
        out.metallic = clamped(pbr.metallicFactor, 0, 1, 1);
        out.roughness = clamped(pbr.roughnessFactor, 0, 1, 1);
        out.base_color_map = map(pbr.baseColorTexture, true);
        out.metallic_roughness_map = map(pbr.metallicRoughnessTexture, false);
        out.normal_map = map(m.normalTexture, false);
        out.normal_scale = clamped(m.normalTexture.scale, -100, 100, 1);
        out.emission_map = map(m.emissiveTexture, true);
        if (m.emissiveFactor.size() == 3)
            out.emission = {clamped(m.emissiveFactor[0], 0, 1e6, 0),
                            clamped(m.emissiveFactor[1], 0, 1e6, 0),
                            clamped(m.emissiveFactor[2], 0, 1e6, 0)};
        out.two_sided = m.doubleSided;
        extensions(m, out);
        if (m.alphaMode == "MASK") {
            out.alpha = Material::Alpha::mask;
            out.alpha_cutoff = clamped(m.alphaCutoff, 0, 1e6, 0.5);
        } else if (m.alphaMode == "BLEND") {
            out.alpha = Material::Alpha::blend;
        } else if (m.alphaMode != "OPAQUE" && !m.alphaMode.empty()) {
            file_.fail(what_,
                       fmt::format("alphaMode '{}'; known: OPAQUE, MASK, BLEND", m.alphaMode));
        }
        if (out.alpha != Material::Alpha::opaque)
            out.alpha_map = out.base_color_map;
        else
            out.opacity = 1;
        sets = sets_;
        return out;
    }

  private:
    void color(const std::vector<double>& factor, Material& out) {
        if (factor.size() < 3) {
            out.base_color = {1, 1, 1};
            return;
        }
        out.base_color = {clamped(factor[0], 0, 1, 1), clamped(factor[1], 0, 1, 1),
                          clamped(factor[2], 0, 1, 1)};
        if (factor.size() > 3) out.opacity = clamped(factor[3], 0, 1, 1);
    }

    void extensions(const tinygltf::Material& m, Material& out) {
        if (const Value* v = extension(m.extensions, "KHR_materials_emissive_strength"))
            out.emission = out.emission * clamped(number(*v, "emissiveStrength", 1), 0, 1e9, 1);
        if (const Value* v = extension(m.extensions, "KHR_materials_ior"))
            out.ior = clamped(number(*v, "ior", 1.5f), 1, 10, 1.5);
        if (const Value* v = extension(m.extensions, "KHR_materials_transmission")) {
            out.transmission = clamped(number(*v, "transmissionFactor", 0), 0, 1, 0);
            if (const Value* t = member(*v, "transmissionTexture"))
                out.transmission_map = map(*t, false);
        }
        // A body of glass bends light; without a volume the surface is a thin sheet.
        if (const Value* v = extension(m.extensions, "KHR_materials_volume"))
            if (number(*v, "thicknessFactor", 0) > 0 && out.transmission > 0.5f) {
                if (out.transmission_map.used())
                    warnings_.push_back(fmt::format(
                        "{}: {}: glass in the places of its transmission texture only; it is taken "
                        "as a thin sheet, which does not bend light",
                        file_.path(), what_));
                else
                    out.kind = Material::Kind::dielectric;
            }
        if (const Value* v = extension(m.extensions, "KHR_materials_pbrSpecularGlossiness")) {
            const std::vector<float> diffuse = numbers(*v, "diffuseFactor");
            color({diffuse.begin(), diffuse.end()}, out);
            out.metallic = 0;
            out.roughness = clamped(1 - number(*v, "glossinessFactor", 1), 0, 1, 1);
            out.metallic_roughness_map = {};
            if (const Value* t = member(*v, "diffuseTexture")) out.base_color_map = map(*t, true);
            warnings_.push_back(
                fmt::format("{}: {}: specular-glossiness is taken as its diffuse part with a gloss",
                            file_.path(), what_));
        }
        if (extension(m.extensions, "KHR_materials_unlit")) out.kind = Material::Kind::diffuse;
    }

    template <class Info>
    TextureMap map(const Info& info, bool color) {
        if (info.index < 0) return {};
        return map(info.index, info.texCoord, extension(info.extensions, "KHR_texture_transform"),
                   color);
    }

    // Of an extension, which tinygltf leaves as it is.
    TextureMap map(const Value& info, bool color) {
        const Value* all = member(info, "extensions");
        const Value* transform = all ? member(*all, "KHR_texture_transform") : nullptr;
        return map(whole(info, "index", -1), whole(info, "texCoord", 0), transform, color);
    }

    TextureMap map(int index, int set, const Value* transform, bool color) {
        TextureMap out;
        const auto& texture =
            model_.textures[file_.index(index, model_.textures.size(), what_, "texture")];
        int source = texture.source;
        if (const Value* v = extension(texture.extensions, "EXT_texture_webp"))
            source = whole(*v, "source", source);
        if (source < 0) {
            if (texture.extensions.count("KHR_texture_basisu"))
                file_.fail(fmt::format("{}, texture {}", what_, index),
                           "only a KTX2 picture (KHR_texture_basisu), which is not read; export it "
                           "again with PNG or JPEG textures");
            warnings_.push_back(fmt::format("{}: {}: texture {} has no picture; left out",
                                            file_.path(), what_, index));
            return out;
        }
        out.file = picture(file_.index(source, model_.images.size(), what_, "image"), color);
        if (texture.sampler >= 0) {
            const auto& sampler = model_.samplers[file_.index(
                texture.sampler, model_.samplers.size(), what_, "sampler")];
            out.wrap_u = wrap(sampler.wrapS), out.wrap_v = wrap(sampler.wrapT);
        }
        if (transform) {
            const auto pair = [&](const char* key, Vec2 fallback) {
                const std::vector<float> v = numbers(*transform, key);
                return v.size() == 2 && std::isfinite(v[0]) && std::isfinite(v[1])
                           ? Vec2{v[0], v[1]}
                           : fallback;
            };
            out.offset = pair("offset", {0, 0}), out.scale = pair("scale", {1, 1});
            const float angle = number(*transform, "rotation", 0);
            out.rotation = std::isfinite(angle) ? angle : 0;
            set = whole(*transform, "texCoord", set);
        }
        out.uv_set = slot(set);
        return out;
    }

    // Where a mesh will have set `set` of texture coordinates.
    int slot(int set) {
        if (set < 0)
            file_.fail(what_,
                       fmt::format("a texture reads set {} of texture coordinates (texCoord); "
                                   "expected 0 or more",
                                   set));
        const auto known = std::find(sets_.begin(), sets_.end(), set);
        if (known != sets_.end()) return int(known - sets_.begin());
        if (sets_.size() == 2) {
            warnings_.push_back(fmt::format(
                "{}: {}: its textures read sets {}, {} and {} of texture coordinates; two can be "
                "read, what is on {} takes {}",
                file_.path(), what_, sets_[0], sets_[1], set, set, sets_[0]));
            return 0;
        }
        sets_.push_back(set);
        return int(sets_.size()) - 1;
    }

    static TextureMap::Wrap wrap(int mode) {
        if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureMap::Wrap::clamp;
        if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return TextureMap::Wrap::mirror;
        return TextureMap::Wrap::repeat;
    }

    // The scene's texture for a picture, one for colours and one for numbers.
    int picture(size_t i, bool color) {
        const auto known = pictures_.find({i, color});
        if (known != pictures_.end()) return known->second;
        const tinygltf::Image& image = model_.images[i];
        TextureFile out;
        out.color = color;
        if (image.bufferView >= 0 || !image.image.empty()) {
            out.bytes = std::make_shared<const std::string>(
                image.bufferView >= 0
                    ? file_.bytes(image.bufferView, fmt::format("{}, image {}", what_, i))
                    : std::string(image.image.begin(), image.image.end()));
            const bool png = out.bytes->starts_with("\x89PNG");
            const bool webp = out.bytes->starts_with("RIFF");
            out.path = fmt::format("{}#image{}.{}", file_.path(), i,
                                   png    ? "png"
                                   : webp ? "webp"
                                          : "jpg");
        } else {
            const std::string name = decoded_uri(image.uri);
            if (name.empty() || name.starts_with("data:"))
                file_.fail(fmt::format("{}, image {}", what_, i),
                           "it has neither a file nor bytes of its own");
            out.path = (std::filesystem::path(file_.path()).parent_path() / name).string();
            if (!file_there(out.path))
                file_.fail(fmt::format("{}, image {}", what_, i),
                           fmt::format("no file '{}' beside it", name));
        }
        scene_.textures.push_back(std::move(out));
        return pictures_[{i, color}] = int(scene_.textures.size()) - 1;
    }

    const GltfFile& file_;
    const tinygltf::Model& model_;
    Scene& scene_;
    std::vector<std::string>& warnings_;
    std::map<std::pair<size_t, bool>, int> pictures_;
    std::string what_;
    GltfUvSets sets_;
};

}  // namespace

std::vector<GltfUvSets> add_gltf_materials(const GltfFile& file, Scene& scene,
                                           std::vector<std::string>& warnings) {
    Reader reader(file, scene, warnings);
    std::vector<GltfUvSets> sets;
    for (size_t i = 0; i < file.model().materials.size(); ++i) {
        sets.emplace_back();
        scene.materials.push_back(reader.material(file.model().materials[i], i, sets.back()));
    }
    Material plain;  // glTF 2.0's default material: every member's own default
    plain.name = "without material";
    plain.base_color = {1, 1, 1};
    plain.metallic = plain.roughness = 1;
    plain.two_sided = false;
    scene.materials.push_back(plain);
    sets.emplace_back();
    return sets;
}

}  // namespace weft
