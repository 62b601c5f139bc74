#include "render/gltf_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

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

    // The material, and the set of texture coordinates that it reads.
    Material material(const tinygltf::Material& m, size_t i, int& set) {
        what_ = m.name.empty() ? fmt::format("material {}", i)
                               : fmt::format("material {} ('{}')", i, m.name);
        set_.reset();
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
        set = set_.value_or(0);
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
            if (member(*v, "transmissionTexture"))
                warnings_.push_back(fmt::format("{}: {}: its transmission texture is left out",
                                                file_.path(), what_));
        }
        // A body of glass bends light; without a volume the surface is a thin sheet.
        if (const Value* v = extension(m.extensions, "KHR_materials_volume"))
            if (number(*v, "thicknessFactor", 0) > 0 && out.transmission > 0.5f)
                out.kind = Material::Kind::dielectric;
        if (const Value* v = extension(m.extensions, "KHR_materials_pbrSpecularGlossiness")) {
            const std::vector<float> diffuse = numbers(*v, "diffuseFactor");
            color({diffuse.begin(), diffuse.end()}, out);
            out.metallic = 0;
            out.roughness = clamped(1 - number(*v, "glossinessFactor", 1), 0, 1, 1);
            out.metallic_roughness_map = {};
            if (const Value* t = member(*v, "diffuseTexture"))
                out.base_color_map =
                    map(whole(*t, "index", -1), whole(*t, "texCoord", 0), nullptr, true);
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
        if (set_ && *set_ != set)
            warnings_.push_back(fmt::format(
                "{}: {}: its textures use sets {} and {} of texture coordinates; all take {}",
                file_.path(), what_, *set_, set, *set_));
        if (!set_) set_ = std::clamp(set, 0, 100);
        return out;
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
        if (!image.image.empty()) {
            out.bytes = std::make_shared<const std::string>(image.image.begin(), image.image.end());
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
            if (!std::filesystem::is_regular_file(out.path))
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
    std::optional<int> set_;
};

}  // namespace

std::vector<int> add_gltf_materials(const GltfFile& file, Scene& scene,
                                    std::vector<std::string>& warnings) {
    Reader reader(file, scene, warnings);
    std::vector<int> sets;
    for (size_t i = 0; i < file.model().materials.size(); ++i) {
        sets.push_back(0);
        scene.materials.push_back(reader.material(file.model().materials[i], i, sets.back()));
    }
    Material plain;  // glTF's default, a metal as rough as can be, is nobody's wish: white plaster
    plain.name = "without material";
    plain.base_color = {0.8f, 0.8f, 0.8f};
    scene.materials.push_back(plain);
    sets.push_back(0);
    return sets;
}

}  // namespace weft
