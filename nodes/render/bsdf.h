// Bsdf: one surface point's reflection, whichever model its material asks for.
#pragma once
#include <variant>

#include "render/conductor_bsdf.h"
#include "render/dielectric_bsdf.h"
#include "render/diffuse_bsdf.h"
#include "render/glass_bsdf.h"
#include "render/metallic_roughness_bsdf.h"
#include "render/mirror_bsdf.h"
#include "render/scene.h"

namespace weft::render {

struct Bsdf {
    std::variant<DiffuseBsdf, ConductorBsdf, MirrorBsdf, DielectricBsdf, GlassBsdf,
                 MetallicRoughnessBsdf>
        of;

    BsdfValue eval(Vec3 out, Vec3 in) const {
        return std::visit([&](const auto& bsdf) { return bsdf.eval(out, in); }, of);
    }
    BsdfSample sample(Vec3 out, float lobe, float a, float b) const {
        return std::visit([&](const auto& bsdf) { return bsdf.sample(out, lobe, a, b); }, of);
    }
    // Nothing but deltas: lights cannot be sampled.
    bool delta() const {
        return std::holds_alternative<MirrorBsdf>(of) || std::holds_alternative<GlassBsdf>(of);
    }
    // `out` and normal keep their sides, since inside and outside differ.
    bool has_inside() const {
        return std::holds_alternative<DielectricBsdf>(of) || std::holds_alternative<GlassBsdf>(of);
    }
};

// From a material's numbers, maps looked up. roughness: perceptual.
inline Bsdf make_bsdf(Material::Kind kind, Vec3 base_color, float metallic, float roughness,
                      float ior, float transmission) {
    const auto in_unit = [](float x) { return std::min(std::max(x, 0.0f), 1.0f); };
    base_color = {in_unit(base_color.x), in_unit(base_color.y), in_unit(base_color.z)};
    const float alpha = alpha_of(in_unit(roughness));
    ior = std::max(ior, 1.0001f);
    switch (kind) {
        case Material::Kind::diffuse:
            return {DiffuseBsdf{base_color}};
        case Material::Kind::conductor:
            if (alpha < smallest_alpha) return {MirrorBsdf{base_color}};
            return {ConductorBsdf{base_color, alpha}};
        case Material::Kind::dielectric:
            if (alpha < smallest_alpha) return {GlassBsdf{base_color, ior}};
            return {DielectricBsdf{base_color, ior, alpha}};
        case Material::Kind::metallic_roughness:
            break;
    }
    metallic = in_unit(metallic);
    if (alpha < smallest_alpha && metallic == 1) return {MirrorBsdf{base_color}};
    return {MetallicRoughnessBsdf{base_color, metallic, std::max(alpha, smallest_alpha), ior,
                                  in_unit(transmission)}};
}

}  // namespace weft::render
