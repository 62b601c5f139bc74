#include "render/lights.h"

#include <algorithm>

#include "render/bsdf_sample.h"
#include "render/shading_frame.h"
#include "render/surface.h"
#include "samples/samplers.h"

namespace weft::render {
namespace {

struct Place {
    size_t index;
    float part;  // in [0, 1), of the step
};
Place place_of(const std::vector<float>& sums, float number) {
    const size_t n = sums.size() - 1;
    size_t i = size_t(std::upper_bound(sums.begin(), sums.end(), number) - sums.begin());
    i = std::clamp<size_t>(i, 1, n) - 1;
    const float step = sums[i + 1] - sums[i];
    return {i, step > 0 ? std::clamp((number - sums[i]) / step, 0.0f, 0x1.fffffep-1f) : 0.5f};
}

float area_of(const Object& object, std::uint32_t primitive, float time) {
    const Vec3 a = position_at(object, primitive, 0, 0, time),
               b = position_at(object, primitive, 1, 0, time),
               c = position_at(object, primitive, 0, 1, time);
    return 0.5f * length(cross(b - a, c - a));
}

// Of a sphere seen from `from`: 1 - cosine of the cone it fills; 0 from inside.
float cone_of(Vec3 center, float radius, Vec3 from, float& sine2) {
    const Vec3 d = center - from;
    const float distance2 = dot(d, d);
    if (distance2 <= radius * radius) return 0;
    sine2 = radius * radius / distance2;
    // 1 - cos without losing digits for small spheres.
    return sine2 < 1e-3f ? 0.5f * sine2 + 0.125f * sine2 * sine2 : 1 - std::sqrt(1 - sine2);
}

// A spot's light falls off smoothly between its two cones.
float spot_part(float cosine, float inner, float outer) {
    if (cosine >= inner) return 1;
    if (cosine <= outer) return 0;
    const float x = (cosine - outer) / (inner - outer);
    return x * x * (3 - 2 * x);
}

}  // namespace

Lights::Lights(const RayScene& rays, const Textures* textures) : rays_(rays) {
    const Scene& scene = rays.scene();
    light_of_.assign(rays.objects().size(), no_object);
    for (const Light& light : scene.lights) {
        One one;
        const bool usable =
            !light.to_world.empty() &&
            std::all_of(light.to_world.begin(), light.to_world.end(),
                        [](const Affine& m) { return finite(m) && is_invertible(m); });
        if (usable) {
            one.kind = Kind(int(light.shape));
            one.placement = placement_of(light);
        }
        one.radiance = light.radiance;
        one.unseen = !light.visible;
        one.inner = std::cos(std::min(light.inner_cone, light.outer_cone));
        one.outer = std::cos(light.outer_cone);
        if (one.inner <= one.outer) one.inner = one.outer + 1e-6f;
        const Affine m = usable ? one.placement.at(0.5f) : Affine{};
        const float l = luminance(light.radiance);
        switch (one.kind) {
            case Kind::quad:
                one.power = l * pi * 4 * length(cross(m.x, m.y));
                break;
            case Kind::disc:
                one.power = l * pi * pi * length(cross(m.x, m.y));
                break;
            case Kind::sphere:
                one.power = l * pi * 4 * pi * dot(m.x, m.x);
                break;
            case Kind::point:
                one.power = l * 4 * pi;
                break;
            case Kind::spot:
                one.power = l * 2 * pi * (1 - 0.5f * (one.inner + one.outer));
                break;
            case Kind::directional:
                one.power = l;
                break;
            default:
                break;
        }
        lights_.push_back(std::move(one));
    }
    for (std::uint32_t i = 0; i < rays.objects().size(); ++i) {
        const Object& object = rays.objects()[i];
        if (object.light >= 0)
            light_of_[i] = std::uint32_t(object.light);
        else if (scene.materials[size_t(object.material)].emits())
            add_mesh(rays, i, textures);
    }
    environment_ = EnvironmentLight(scene.environment);
    One sky;
    if (environment_.present()) {
        sky.kind = Kind::environment;
        sky.power = pi * luminance(environment_.mean());
    }
    lights_.push_back(std::move(sky));
    choose();
}

void Lights::add_mesh(const RayScene& rays, std::uint32_t index, const Textures* textures) {
    const Object& object = rays.objects()[index];
    const Material& material = rays.scene().materials[size_t(object.material)];
    const size_t n = object.mesh->triangles.size();
    One one;
    one.kind = Kind::mesh;
    one.radiance = material.emission;
    one.object = index;
    one.two_sided = material.two_sided;
    // What a map makes of the emission: one look at each triangle, as wide as it is.
    std::vector<float> rgba(4 * n, 1.0f);
    const std::vector<Vec2>& coordinates = object.mesh->uv_set(material.emission_map.uv_set);
    if (textures && material.emission_map.used() && !coordinates.empty()) {
        std::vector<Vec2> uv(n);
        std::vector<float> width(n), half(n, 0.5f);
        for (size_t t = 0; t < n; ++t) {
            const auto& corner = object.mesh->triangles[t];
            const Vec2 a = coordinates[corner[0]], b = coordinates[corner[1]],
                       c = coordinates[corner[2]];
            uv[t] = place(material.emission_map, {(a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3});
            width[t] =
                std::sqrt(std::fabs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) *
                          std::fabs(material.emission_map.scale.x * material.emission_map.scale.y));
        }
        textures->lookup(material.emission_map.file, material.emission_map.wrap_u,
                         material.emission_map.wrap_v, uv, width, half, rgba);
    }
    std::vector<double> sums(n + 1, 0);
    for (size_t t = 0; t < n; ++t) {
        const Vec3 e = material.emission * Vec3{rgba[4 * t], rgba[4 * t + 1], rgba[4 * t + 2]};
        const double weight =
            double(std::max(luminance(e), 0.0f)) * double(area_of(object, std::uint32_t(t), 0.5f));
        sums[t + 1] = sums[t] + weight;
    }
    if (!(sums[n] > 0)) return;
    one.power = float(sums[n]) * pi * (one.two_sided ? 2.0f : 1.0f);
    one.sums.resize(n + 1);
    for (size_t t = 0; t <= n; ++t) one.sums[t] = float(sums[t] / sums[n]);
    one.sums[n] = 1;
    light_of_[index] = std::uint32_t(lights_.size());
    lights_.push_back(std::move(one));
}

// What comes from infinitely far is measured by irradiance and cannot be compared with watts
// without knowing what part of the scene is looked at: where there are both, each side gets half.
void Lights::choose() {
    const auto far = [](const One& one) {
        return one.kind == Kind::environment || one.kind == Kind::directional;
    };
    double sides[2] = {0, 0};
    for (const One& one : lights_) sides[far(one)] += double(one.power);
    if (!(sides[0] + sides[1] > 0)) return;
    for (One& one : lights_)
        if (one.power > 0) one.power /= float(sides[far(one)]);
    double all = 0;
    for (const One& one : lights_) all += double(one.power);
    double before = 0;
    sums_.push_back(0);
    for (std::uint32_t i = 0; i < lights_.size(); ++i) {
        if (!(lights_[i].power > 0)) continue;
        before += double(lights_[i].power);
        chosen_.push_back(i);
        sums_.push_back(float(before / all));
        lights_[i].probability = sums_.back() - sums_[sums_.size() - 2];
    }
    sums_.back() = 1;
    lights_[chosen_.back()].probability = 1 - sums_[sums_.size() - 2];
}

LightSample Lights::sample(Vec3 from, float time, float choice, float a, float b) const {
    LightSample out;
    if (chosen_.empty()) return out;
    const Place place = place_of(sums_, choice);
    out.light = chosen_[place.index];
    const One& one = lights_[out.light];
    if (one.kind == Kind::environment) {
        const EnvironmentLight::Direction d = environment_.sample(a, b);
        if (!(d.density > 0)) return out;
        out.direction = d.direction;
        out.distance = infinity;
        out.radiance = environment_.radiance(d.direction);
        out.density = d.density * one.probability;
        return out;
    }
    if (one.kind == Kind::mesh) {
        const Place triangle = place_of(one.sums, place.part);
        const Object& object = rays_.objects()[one.object];
        const float root = std::sqrt(a), u = 1 - root, v = b * root;
        const auto primitive = std::uint32_t(triangle.index);
        const SurfacePoint point = surface_at(object, primitive, u, v, time);
        const Vec3 d = point.position - from;
        const float distance2 = dot(d, d), distance = std::sqrt(distance2);
        if (!(distance > 0)) return out;
        out.direction = d * (1 / distance);
        out.distance = distance;
        const float cosine = -dot(out.direction, point.geometric);
        if (!one.two_sided && cosine <= 0) return out;
        const float area = area_of(object, primitive, time);
        const float chance = one.sums[triangle.index + 1] - one.sums[triangle.index];
        if (!(std::fabs(cosine) > 1e-7f) || !(area > 0)) return out;
        out.density = one.probability * chance / area * distance2 / std::fabs(cosine);
        out.radiance = one.radiance;
        out.object = one.object, out.primitive = primitive, out.u = u, out.v = v;
        return out;
    }
    const Affine m = one.placement.at(time);
    out.delta = one.unseen;
    switch (one.kind) {
        case Kind::quad:
        case Kind::disc: {
            Vec2 l{2 * a - 1, 2 * b - 1};
            if (one.kind == Kind::disc) {
                const Disk disk = concentric_disk(a, b);
                l = {disk.u, disk.v};
            }
            const Vec3 across = cross(m.x, m.y), d = m.point({l.x, l.y, 0}) - from;
            const float size = length(across), distance2 = dot(d, d),
                        distance = std::sqrt(distance2);
            if (!(distance > 0)) return out;
            out.direction = d * (1 / distance);
            out.distance = distance;
            // The light shines along -z; z may have been mirrored.
            const Vec3 normal = unit(transformed_normal(m, {0, 0, -1}));
            const float cosine = -dot(out.direction, normal);
            if (cosine <= 1e-7f) return out;
            const float area = size * (one.kind == Kind::quad ? 4 : pi);
            out.density = one.probability * distance2 / (cosine * area);
            out.radiance = one.radiance;
            return out;
        }
        case Kind::sphere: {
            const float radius = length(m.x);
            float sine2 = 0;
            const float cone = cone_of(m.origin, radius, from, sine2);
            if (!(cone > 0)) return out;
            const float up = a * cone;  // 1 - cos
            const float cosine = 1 - up, sine = std::sqrt(std::max(0.0f, up * (2 - up)));
            const Vec3 d = m.origin - from;
            const float far = length(d);
            const ShadingFrame frame(d * (1 / far));
            out.direction =
                frame.to_world({sine * std::cos(2 * pi * b), sine * std::sin(2 * pi * b), cosine});
            const float along = dot(d, out.direction);
            const float inside = std::max(0.0f, radius * radius - (far * far - along * along));
            out.distance = along - std::sqrt(inside);
            out.density = one.probability / (2 * pi * cone);
            out.radiance = one.radiance;
            return out;
        }
        case Kind::point:
        case Kind::spot: {
            const Vec3 d = m.origin - from;
            const float distance2 = dot(d, d);
            if (!(distance2 > 0)) return out;
            out.distance = std::sqrt(distance2);
            out.direction = d * (1 / out.distance);
            out.delta = true;
            const float part = one.kind == Kind::point
                                   ? 1
                                   : spot_part(dot(out.direction, unit(m.z)), one.inner, one.outer);
            if (part <= 0) return out;
            out.density = one.probability;
            out.radiance = one.radiance * (part / distance2);
            return out;
        }
        case Kind::directional:
            out.direction = unit(m.z);
            out.distance = infinity;
            out.delta = true;
            out.density = one.probability;
            out.radiance = one.radiance;
            return out;
        default:
            return out;
    }
}

float Lights::density(Vec3 from, float time, std::uint32_t object_index, std::uint32_t primitive,
                      float u, float v) const {
    const std::uint32_t light = light_of_[object_index];
    if (light == no_object) return 0;
    const One& one = lights_[light];
    const Object& object = rays_.objects()[object_index];
    if (one.kind == Kind::sphere) {
        const Affine m = object.placement.at(time);
        float sine2 = 0;
        const float cone = cone_of(m.origin, length(m.x), from, sine2);
        return cone > 0 ? one.probability / (2 * pi * cone) : 0;
    }
    const SurfacePoint point = surface_at(object, primitive, u, v, time);
    const Vec3 d = point.position - from;
    const float distance2 = dot(d, d);
    const float cosine = std::fabs(dot(d, point.geometric)) / std::sqrt(distance2);
    if (!(cosine > 1e-7f)) return 0;
    if (one.kind == Kind::mesh) {
        const float area = area_of(object, primitive, time);
        const float chance = one.sums[primitive + 1] - one.sums[primitive];
        return area > 0 ? one.probability * chance / area * distance2 / cosine : 0;
    }
    const Affine m = object.placement.at(time);
    const float area = length(cross(m.x, m.y)) * (one.kind == Kind::quad ? 4 : pi);
    return one.probability * distance2 / (cosine * area);
}

float Lights::environment_density(Vec3 direction) const {
    return environment_.present() ? environment_.density(direction) * lights_.back().probability
                                  : 0;
}

}  // namespace weft::render
