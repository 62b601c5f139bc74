// glTF 2.0's metallic-roughness material, with KHR_materials_ior and KHR_materials_transmission
// (a thin sheet: what goes through is not bent). Two-sided: `out` has z > 0.
// Source: glTF 2.0, appendix B. Departure: its diffuse term is (1 - F) albedo / pi, which returns
// more light than it gets near grazing angles; ours is coupled with the specular lobe's albedo E
// (Kelemen and Szirmay-Kalos 2001), (1 - E(out)) (1 - E(in)) / (1 - E mean), reciprocal and never
// above 1.
#pragma once
#include "render/diffuse_bsdf.h"
#include "render/ggx_albedo.h"
#include "render/microfacet.h"

namespace weft::render {

struct MetallicRoughnessBsdf {
    Vec3 base_color;
    float metallic, alpha, ior, transmission;
    bool clear = false;  // smooth: what goes through is a delta, straight on

    BsdfValue eval(Vec3 out, Vec3 in) const {
        if (out.z <= 0 || in.z == 0) return {};
        const Parts p = parts(out);
        if (in.z < 0) return through(p, out, in);
        const Ggx ggx{alpha};
        const Vec3 m = unit(out + in);
        const float d = ggx.distribution(m);
        BsdfValue value;
        value.specular = schlick(p.normal_incidence, dot(out, m)) *
                         (d * ggx.masking_shadowing(out, in) / (4 * out.z));
        const float e_in = ggx_albedo(in.z, alpha).of(p.dielectric);
        value.diffuse =
            base_color * (p.diffuse * (1 - p.e_out) * (1 - e_in) / (1 - p.e_mean) * in.z / pi);
        value.density =
            p.pick_specular * d * ggx.masking(out) / (4 * out.z) + p.pick_diffuse * in.z / pi;
        return value;
    }

    BsdfSample sample(Vec3 out, float lobe, float a, float b) const {
        if (out.z <= 0) return {};
        const Parts p = parts(out);
        Vec3 in;
        const bool passes = lobe >= p.pick_specular + p.pick_diffuse;
        if (passes && clear)
            return {-out, {{}, transmittance(out), p.pick_through}, true, true, true};
        if (lobe < p.pick_specular || passes) {
            in = reflected(out, Ggx{alpha}.sample_visible(out, a, b));
            if (in.z <= 0) return {};
            if (passes) in.z = -in.z;
        } else {
            in = cosine_direction(a, b);
        }
        return {in, eval(out, in), false, passes};
    }

    Vec3 transmittance(Vec3 out) const {
        if (!clear || out.z <= 0) return {};
        const float r = (ior - 1) / (ior + 1);
        return base_color *
               ((1 - metallic) * transmission * (1 - r * r) * (1 - schlick_weight(out.z)));
    }

  private:
    struct Parts {
        Vec3 normal_incidence;   // of the specular lobe
        float dielectric;        // normal incidence of the part that is no metal
        float diffuse, through;  // weights of these lobes, colour apart
        float e_out, e_mean;     // the dielectric lobe's albedo
        float pick_specular, pick_diffuse, pick_through;
    };
    Parts parts(Vec3 out) const {
        Parts p;
        const float r = (ior - 1) / (ior + 1);
        p.dielectric = r * r;
        p.normal_incidence = white * (p.dielectric * (1 - metallic)) + base_color * metallic;
        p.diffuse = (1 - metallic) * (1 - transmission);
        p.through = (1 - metallic) * transmission;
        const GgxAlbedo e = ggx_albedo(out.z, alpha);
        p.e_out = std::min(e.of(p.dielectric), 0.999f);
        p.e_mean = std::min(ggx_mean_albedo(alpha).of(p.dielectric), 0.999f);
        // Lobes are chosen by what they are about to return.
        const float base = largest(base_color);
        const float specular = e.scale * largest(p.normal_incidence) + e.bias;
        const float diffuse = base * p.diffuse * (1 - p.e_out),
                    pass = base * p.through * (1 - p.e_out);
        const float all = specular + diffuse + pass;
        p.pick_specular = all > 0 ? specular / all : 1;
        p.pick_diffuse = all > 0 ? diffuse / all : 0;
        p.pick_through = all > 0 ? std::max(0.0f, 1 - p.pick_specular - p.pick_diffuse) : 0;
        if (pass <= 0) p.pick_through = 0, p.pick_diffuse = 1 - p.pick_specular;
        return p;
    }
    // Microfacets let light through as they reflect it, mirrored about the sheet.
    BsdfValue through(const Parts& p, Vec3 out, Vec3 in) const {
        if (p.through <= 0 || clear) return {};
        const Vec3 above{in.x, in.y, -in.z};
        const Ggx ggx{alpha};
        const Vec3 m = unit(out + above);
        const float d = ggx.distribution(m), weight = schlick_weight(dot(out, m));
        const float pass = (1 - p.dielectric) * (1 - weight);
        return {
            {},
            base_color * (p.through * pass * d * ggx.masking_shadowing(out, above) / (4 * out.z)),
            p.pick_through * d * ggx.masking(out) / (4 * out.z)};
    }
};

}  // namespace weft::render
