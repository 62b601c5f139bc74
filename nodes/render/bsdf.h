// Bsdf: one surface point's reflection, whichever model its material asks for.
#pragma once
#include <variant>

#include "render/clear_bsdf.h"
#include "render/conductor_bsdf.h"
#include "render/dielectric_bsdf.h"
#include "render/diffuse_bsdf.h"
#include "render/glass_bsdf.h"
#include "render/metallic_roughness_bsdf.h"
#include "render/mirror_bsdf.h"
#include "render/scene.h"

namespace weft::render {

struct Bsdf {
    std::variant<DiffuseBsdf, ConductorBsdf, MirrorBsdf, DielectricBsdf, GlassBsdf, ClearBsdf,
                 MetallicRoughnessBsdf>
        of;

    BsdfValue eval(Vec3 out, Vec3 in) const {
        return std::visit([&](const auto& bsdf) { return bsdf.eval(out, in); }, of);
    }
    BsdfSample sample(Vec3 out, float lobe, float a, float b) const {
        return std::visit([&](const auto& bsdf) { return bsdf.sample(out, lobe, a, b); }, of);
    }
    // What part of the light that comes from -out goes straight on to `out`: of a shadow ray's
    // light, and of the path's that sample() sends on unbent.
    Vec3 transmittance(Vec3 out) const {
        return std::visit(
            [&](const auto& bsdf) -> Vec3 {
                if constexpr (requires { bsdf.transmittance(out); }) return bsdf.transmittance(out);
                return {};
            },
            of);
    }
    // Nothing but deltas: lights cannot be sampled.
    bool delta() const { return is<MirrorBsdf>() || is<GlassBsdf>() || is<ClearBsdf>(); }
    // `out` and normal keep their sides, since inside and outside differ.
    bool has_inside() const { return is<DielectricBsdf>() || is<GlassBsdf>() || is<ClearBsdf>(); }

  private:
    template <class Model>
    bool is() const {
        return std::holds_alternative<Model>(of);
    }
};

// From a material's numbers, maps looked up. roughness: perceptual.
inline Bsdf make_bsdf(Material::Kind kind, Vec3 base_color, float metallic, float roughness,
                      float ior, float transmission) {
    const auto in_unit = [](float x) { return std::min(std::max(x, 0.0f), 1.0f); };
    base_color = {in_unit(base_color.x), in_unit(base_color.y), in_unit(base_color.z)};
    const float alpha = alpha_of(in_unit(roughness));
    const bool bends = ior > 1;
    ior = std::max(ior, 1.0001f);
    switch (kind) {
        case Material::Kind::diffuse:
            return {DiffuseBsdf{base_color}};
        case Material::Kind::conductor:
            if (alpha < smallest_alpha) return {MirrorBsdf{base_color}};
            return {ConductorBsdf{base_color, alpha}};
        case Material::Kind::dielectric:
            if (!bends) return {ClearBsdf{base_color}};
            if (alpha < smallest_alpha) return {GlassBsdf{base_color, ior}};
            return {DielectricBsdf{base_color, ior, alpha}};
        case Material::Kind::metallic_roughness:
            break;
    }
    metallic = in_unit(metallic);
    if (alpha < smallest_alpha && metallic == 1) return {MirrorBsdf{base_color}};
    return {MetallicRoughnessBsdf{base_color, metallic, std::max(alpha, smallest_alpha), ior,
                                  in_unit(transmission), alpha < smallest_alpha}};
}

// Whether a surface of this material may let light straight through, wherever maps allow it.
inline bool may_be_clear(const Material& m) {
    if (m.kind == Material::Kind::dielectric) return m.ior <= 1;
    if (m.kind != Material::Kind::metallic_roughness || !(m.transmission > 0)) return false;
    const bool mapped = m.metallic_roughness_map.used();
    return (m.metallic < 1 || mapped) && (alpha_of(m.roughness) < smallest_alpha || mapped);
}

}  // namespace weft::render
