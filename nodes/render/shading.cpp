#include "render/shading.h"

#include <algorithm>
#include <chrono>

#include "samples/random.h"

namespace weft::render {
namespace {

std::uint64_t now_ns() {
    return std::uint64_t(std::chrono::steady_clock::now().time_since_epoch().count());
}

// Texture coordinates a unit of length.
float uv_density(const UvFrame& at) {
    const float area = length(cross(at.along_u, at.along_v));
    return area > 0 ? 1 / std::sqrt(area) : 0;
}

// How the surface runs along a map's own axes, however the picture is placed on it.
UvFrame along_picture(const TextureMap& map, const UvFrame& at) {
    if (map.scale == Vec2{1, 1} && map.rotation == 0) return at;
    if (map.scale.x == 0 || map.scale.y == 0) return {at.uv, {}, {}};
    const Vec3 u = at.along_u * (1 / map.scale.x), v = at.along_v * (1 / map.scale.y);
    const float c = std::cos(map.rotation), r = std::sin(map.rotation);
    return {at.uv, u * c + v * r, v * c - u * r};
}

// A normal that `out` sees: bent towards it where interpolation or a map turned it away.
Vec3 seen_normal(Vec3 normal, Vec3 out) {
    constexpr float least = 0.01f;
    const float c = dot(normal, out);
    return c >= least ? normal : unit(normal + out * (least - c));
}

Vec3 mapped_normal(const UvFrame& at, Vec3 normal, const float* rgba, float scale) {
    const float x = (2 * rgba[0] - 1) * scale, y = (2 * rgba[1] - 1) * scale, z = 2 * rgba[2] - 1;
    // Tangents along the texture's axes, made square to the normal; +y is up the picture, against
    // v.
    Vec3 t = at.along_u - normal * dot(at.along_u, normal);
    const float l = length(t);
    if (!(l > 0)) return normal;
    t = t * (1 / l);
    Vec3 b = cross(normal, t);
    if (dot(b, at.along_v) > 0) b = -b;
    const Vec3 n = t * x + b * y + normal * z;
    const float size = length(n);
    return size > 0 ? n * (1 / size) : normal;
}

}  // namespace

UvFrame Shading::frame_of(const TextureMap& map, const UvFrame& first, const Rays& hits,
                          size_t k) const {
    if (map.uv_set == 0) return first;
    return uv_frame_at(rays_.objects()[hits.object[k]], hits.primitive[k], hits.u[k], hits.v[k],
                       hits.time[k], map.uv_set);
}

void Shading::look_up(const TextureMap& map, const Rays& hits, std::span<const std::uint32_t> group,
                      std::span<const float> footprint, std::span<const float> random,
                      ShadingScratch& s) const {
    const std::uint64_t start = now_ns();
    const size_t n = group.size();
    s.uv.resize(n), s.width.resize(n), s.random.resize(n), s.rgba.resize(4 * n);
    const float scale = std::sqrt(std::fabs(map.scale.x * map.scale.y));
    for (size_t i = 0; i < n; ++i) {
        const std::uint32_t k = group[i];
        const UvFrame at = frame_of(map, s.shades[k].point.texture, hits, k);
        s.uv[i] = place(map, at.uv);
        s.width[i] = footprint[k] * uv_density(at) * scale;
        s.random[i] = random[k];
    }
    textures_->lookup(map.file, map.wrap_u, map.wrap_v, s.uv, s.width, s.random, s.rgba);
    s.lookups += n;
    s.texture_ns += now_ns() - start;
}

void Shading::shade(const Rays& hits, size_t n, std::span<const float> footprint,
                    std::span<const float> random, ShadingScratch& s) const {
    const Scene& scene = rays_.scene();
    const auto& objects = rays_.objects();
    if (s.shades.size() < n) s.shades.resize(n);
    s.order.resize(n);
    s.count.assign(scene.materials.size() + 1, 0);
    for (size_t k = 0; k < n; ++k) {
        const std::uint32_t object = hits.object[k];
        if (object == no_object) continue;
        Shade& shade = s.shades[k];
        shade.point =
            surface_at(objects[object], hits.primitive[k], hits.u[k], hits.v[k], hits.time[k]);
        shade.out = -hits.direction(k);
        shade.light = objects[object].light >= 0;
        if (shade.light) {
            shade.normal = shade.point.geometric;
            shade.emission = lights_.radiance(object);
            shade.albedo = {};
            shade.roughness = 1;
        } else {
            ++s.count[size_t(objects[object].material) + 1];
        }
    }
    for (size_t m = 1; m < s.count.size(); ++m) s.count[m] += s.count[m - 1];
    const size_t surfaces = s.count.back();
    for (size_t k = 0; k < n; ++k)
        if (hits.object[k] != no_object && objects[hits.object[k]].light < 0)
            s.order[s.count[size_t(objects[hits.object[k]].material)]++] = std::uint32_t(k);

    // count[m] is now where material m ends.
    size_t begin = 0;
    for (size_t m = 0; begin < surfaces; ++m) {
        const size_t end = s.count[m];
        if (begin == end) continue;
        const std::span<const std::uint32_t> group(&s.order[begin], end - begin);
        begin = end;
        const Material& mat = scene.materials[m];
        for (const std::uint32_t k : group) {
            Shade& shade = s.shades[k];
            shade.albedo = mat.base_color;
            shade.roughness = mat.roughness;
            shade.emission = mat.emission;
            shade.transmission = mat.transmission;
        }
        float metallic = mat.metallic;
        const auto mapped = [&](const TextureMap& map, auto&& use) {
            if (!map.used() || !textures_) return;
            look_up(map, hits, group, footprint, random, s);
            for (size_t i = 0; i < group.size(); ++i) use(s.shades[group[i]], &s.rgba[4 * i], i);
        };
        mapped(mat.base_color_map, [&](Shade& shade, const float* c, size_t) {
            shade.albedo = shade.albedo * Vec3{c[0], c[1], c[2]};
        });
        mapped(mat.emission_map, [&](Shade& shade, const float* c, size_t) {
            shade.emission = shade.emission * Vec3{c[0], c[1], c[2]};
        });
        mapped(mat.normal_map, [&](Shade& shade, const float* c, size_t i) {
            const UvFrame at = along_picture(
                mat.normal_map, frame_of(mat.normal_map, shade.point.texture, hits, group[i]));
            shade.point.shading = mapped_normal(at, shade.point.shading, c, mat.normal_scale);
        });
        mapped(mat.transmission_map,
               [&](Shade& shade, const float* c, size_t) { shade.transmission *= c[0]; });
        const bool has_metal_map = mat.metallic_roughness_map.used() && textures_;
        mapped(mat.metallic_roughness_map,
               [&](Shade& shade, const float* c, size_t) { shade.roughness *= c[1]; });
        for (size_t i = 0; i < group.size(); ++i) {
            Shade& shade = s.shades[group[i]];
            if (has_metal_map) metallic = mat.metallic * s.rgba[4 * i + 2];
            shade.bsdf = make_bsdf(mat.kind, shade.albedo, metallic, shade.roughness, mat.ior,
                                   shade.transmission);
            SurfacePoint& p = shade.point;
            const bool front = dot(p.geometric, shade.out) >= 0;
            if (!front && !mat.two_sided) shade.emission = {};
            if (shade.bsdf.has_inside()) {
                shade.normal = dot(p.shading, p.geometric) > 0 ? p.shading : p.geometric;
                if ((dot(shade.normal, shade.out) >= 0) != front) shade.normal = p.geometric;
            } else {
                if (!front) p.geometric = -p.geometric, p.shading = -p.shading;
                shade.normal = seen_normal(p.shading, shade.out);
            }
            shade.frame = ShadingFrame(shade.normal);
        }
    }
}

void Shading::light_radiance(std::span<LightSample> lights, ShadingScratch& s) const {
    if (!textures_) return;
    // One light at a time: maps on emitters are rare, and a batch's samples mostly share one.
    for (LightSample& light : lights) {
        if (light.object == no_object || !(light.density > 0)) continue;
        const Material& mat = material(light.object);
        if (!mat.emission_map.used()) continue;
        const std::uint64_t start = now_ns();
        const Object& object = rays_.objects()[light.object];
        const Vec2 uv = place(
            mat.emission_map,
            uv_frame_at(object, light.primitive, light.u, light.v, 0, mat.emission_map.uv_set).uv);
        const float width = 0, half = 0.5f;
        float rgba[4];
        textures_->lookup(mat.emission_map.file, mat.emission_map.wrap_u, mat.emission_map.wrap_v,
                          {&uv, 1}, {&width, 1}, {&half, 1}, rgba);
        light.radiance = light.radiance * Vec3{rgba[0], rgba[1], rgba[2]};
        s.texture_ns += now_ns() - start;
        ++s.lookups;
    }
}

// Opacity of masked hits, material by material: `hits` are sorted by it.
void Shading::opacities(const Rays& rays, std::span<std::uint32_t> hits, float spread,
                        ShadingScratch& s) const {
    const auto& objects = rays_.objects();
    std::stable_sort(hits.begin(), hits.end(), [&](std::uint32_t a, std::uint32_t b) {
        return objects[rays.object[a]].material < objects[rays.object[b]].material;
    });
    s.opacity.resize(hits.size());
    s.error.resize(hits.size());
    for (size_t begin = 0; begin < hits.size();) {
        const Material& mat = material(rays.object[hits[begin]]);
        size_t end = begin;
        while (end < hits.size() && &material(rays.object[hits[end]]) == &mat) ++end;
        const size_t n = end - begin;
        s.uv.resize(n), s.width.resize(n), s.random.assign(n, 0.5f), s.rgba.resize(4 * n);
        for (size_t i = 0; i < n; ++i) {
            const std::uint32_t k = hits[begin + i];
            const SurfacePoint p = surface_at(objects[rays.object[k]], rays.primitive[k], rays.u[k],
                                              rays.v[k], rays.time[k]);
            const UvFrame at = frame_of(mat.alpha_map, p.texture, rays, k);
            s.uv[i] = place(mat.alpha_map, at.uv);
            s.width[i] = spread * rays.distance[k] * uv_density(at) *
                         std::sqrt(std::fabs(mat.alpha_map.scale.x * mat.alpha_map.scale.y));
            s.error[begin + i] = p.error;
            s.opacity[begin + i] = mat.opacity;
        }
        if (mat.alpha_map.used() && textures_) {
            const std::uint64_t start = now_ns();
            textures_->lookup(mat.alpha_map.file, mat.alpha_map.wrap_u, mat.alpha_map.wrap_v, s.uv,
                              s.width, s.random, s.rgba);
            const bool numbers = !rays_.scene().textures[size_t(mat.alpha_map.file)].color &&
                                 !textures_->has_alpha(mat.alpha_map.file);
            for (size_t i = 0; i < n; ++i)
                s.opacity[begin + i] *= s.rgba[4 * i + (numbers ? 0 : 3)];
            s.texture_ns += now_ns() - start;
            s.lookups += n;
        }
        begin = end;
    }
}

void Shading::pass_cutouts(Rays& rays, size_t n, float spread, std::span<const std::uint64_t> keys,
                           ShadingScratch& s) const {
    const auto& objects = rays_.objects();
    s.order.clear();
    for (std::uint32_t k = 0; k < n; ++k)
        if (rays.object[k] != no_object && objects[rays.object[k]].masked) s.order.push_back(k);
    for (int layer = 0; layer < most_layers && !s.order.empty(); ++layer) {
        opacities(rays, s.order, spread, s);
        size_t kept = 0;
        for (size_t i = 0; i < s.order.size(); ++i) {
            const std::uint32_t k = s.order[i];
            const Material& mat = material(rays.object[k]);
            const float least = mat.alpha == Material::Alpha::mask
                                    ? mat.alpha_cutoff
                                    : unit_float(mix(keys[k] + std::uint64_t(layer))) + 1e-9f;
            if (s.opacity[i] >= least) continue;
            rays.near[k] = beyond(rays.distance[k], s.error[i]);
            rays_.intersect(rays, k, k + 1);
            if (rays.object[k] != no_object && objects[rays.object[k]].masked) s.order[kept++] = k;
        }
        s.order.resize(kept);
    }
}

void Shading::transmittance(const Rays& hits, size_t n, float spread, std::span<const float> random,
                            std::span<Vec3> part, ShadingScratch& s) const {
    const auto& objects = rays_.objects();
    s.footprint.resize(n);
    for (size_t k = 0; k < n; ++k) s.footprint[k] = spread * hits.distance[k];
    shade(hits, n, s.footprint, random, s);
    s.order.clear();
    for (std::uint32_t k = 0; k < n; ++k) {
        if (hits.object[k] == no_object) continue;
        const Shade& shade = s.shades[k];
        part[k] = shade.bsdf.transmittance(shade.frame.to_local(shade.out));
        if (objects[hits.object[k]].masked) s.order.push_back(k);
    }
    opacities(hits, s.order, spread, s);
    for (size_t i = 0; i < s.order.size(); ++i) {
        const std::uint32_t k = s.order[i];
        const Material& mat = material(hits.object[k]);
        const float there = mat.alpha != Material::Alpha::mask
                                ? std::clamp(s.opacity[i], 0.0f, 1.0f)
                                : float(s.opacity[i] >= mat.alpha_cutoff);
        part[k] = part[k] * there + white * (1 - there);
    }
}

}  // namespace weft::render
