#include "render/json_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "color/apply_color.h"
#include "image/picture_file.h"
#include "render/file_there.h"

namespace weft {

std::string JsonParts::file(const Json* at, const std::string& name) const {
    const std::string path = (std::filesystem::path(folder) / name).lexically_normal().string();
    if (name.empty() || !file_there(path)) {
        findings.push_back({Diagnostic::Level::error,
                            fmt::format("no file '{}'{}", path,
                                        path.find("scenes/") != std::string::npos
                                            ? "; run tools/scenes, which fetches it"
                                            : ""),
                            at ? at->place : Place{}});
        return {};
    }
    return path;
}

TextureMap JsonParts::map(JsonFields& from, std::string_view key, bool color) {
    TextureMap out;
    const Json* v = from.any(key);
    if (!v) return out;
    std::string path;
    if (v->is(Json::Kind::text)) {
        path = file(v, v->text);
    } else {
        JsonFields fields(v, fmt::format("'{}'", key), findings);
        const Json* at = v->find("file");
        const std::string name = fields.text("file");
        path = file(at ? at : v, name);
        const auto pair = [&](const char* member, Vec2 fallback) {
            const std::vector<float> p = fields.numbers(member, 2, 2);
            return p.empty() ? fallback : Vec2{p[0], p[1]};
        };
        out.scale = pair("scale", {1, 1}), out.offset = pair("offset", {0, 0});
        out.rotation = radians(fields.number("rotate", 0));
        out.wrap_u = out.wrap_v =
            TextureMap::Wrap(fields.choice("wrap", {"repeat", "clamp", "mirror"}, 0));
        fields.end();
    }
    if (path.empty()) return {};
    const auto [known, fresh] = textures.try_emplace({path, color}, int(scene.textures.size()));
    if (fresh) scene.textures.push_back({path, nullptr, color});
    out.file = known->second;
    return out;
}

Material JsonParts::material(const std::string& name, const Json& value) {
    JsonFields f(&value, fmt::format("material '{}'", name), findings);
    Material m;
    m.name = name;
    m.kind = Material::Kind(
        f.choice("kind", {"diffuse", "conductor", "dielectric", "metallic-roughness"}, 3));
    const bool glass = m.kind == Material::Kind::dielectric;
    m.base_color = f.color("color", glass ? Vec3{1, 1, 1} : m.base_color, 1);
    m.base_color_map = map(f, "texture", true);
    if (m.base_color_map.used() && !f.has("color")) m.base_color = {1, 1, 1};
    m.roughness = f.number("roughness",
                           glass                                 ? 0
                           : m.kind == Material::Kind::conductor ? 0.2f
                                                                 : 0.5f,
                           0, 1);
    m.metallic = f.number("metallic", 0, 0, 1);
    m.metallic_roughness_map = map(f, "metallic-roughness-texture", false);
    m.emission = f.color("emission", {});
    m.emission_map = map(f, "emission-texture", true);
    m.ior = f.number("ior", 1.5f, 1, 10);
    m.transmission = f.number("transmission", 0, 0, 1);
    m.transmission_map = map(f, "transmission-texture", false);
    m.alpha = Material::Alpha(f.choice("alpha", {"opaque", "mask", "blend"}, 0));
    m.opacity = f.number("opacity", 1, 0, 1);
    m.alpha_cutoff = f.number("alpha-cutoff", 0.5f, 0, 1);
    m.alpha_map = map(f, "alpha-texture", false);
    if (m.alpha != Material::Alpha::opaque && !m.alpha_map.used()) m.alpha_map = m.base_color_map;
    m.normal_map = map(f, "normal-texture", false);
    m.normal_scale = f.number("normal-scale", 1, -10, 10);
    m.two_sided = f.flag("two-sided", true);
    f.end();
    return m;
}

std::vector<Affine> JsonParts::moved(JsonFields& from, std::vector<Affine> keys) {
    const Vec3 velocity = from.vector("velocity", {}) * seconds;
    const Json* spin = from.object("spin");
    Vec3 axis{0, 1, 0};
    float angle = 0;
    if (spin) {
        JsonFields f(spin, "'spin'", findings);
        axis = f.vector("axis", axis);
        angle = 2 * pi * f.number("turns", 0, -1e4, 1e4) * seconds;
        f.end();
        if (!(dot(axis, axis) > 0)) f.finding(spin, "'axis' is zero"), axis = {0, 1, 0};
        if (std::fabs(angle) > 2 * pi * 20)
            f.finding(spin, "more than 20 turns while the shutter is open"), angle = 0;
    }
    if (keys.size() == 1) {
        if (velocity == Vec3{} && angle == 0) return keys;
        return moving(keys[0], velocity, axis, angle);
    }
    if (angle != 0) from.finding(spin, "it moves already; only 'velocity' can be added");
    for (size_t i = 0; i < keys.size(); ++i)
        keys[i].origin += velocity * (float(i) / float(keys.size() - 1));
    return keys;
}

void JsonParts::light(const Json& value) {
    JsonFields f(&value, "a light", findings);
    Light l;
    l.shape = Light::Shape(
        f.choice("shape", {"quad", "disc", "sphere", "point", "spot", "directional"}, 0));
    l.name = f.text("name", fmt::format("light {}", scene.lights.size()));
    using Lamp = Light::Shape;
    const char* amount = l.area()                       ? "radiance"
                         : l.shape == Lamp::directional ? "irradiance"
                                                        : "intensity";
    l.radiance = f.color(amount, {1, 1, 1});
    const Vec3 at = f.vector("at", l.shape == Lamp::directional ? Vec3{0, 1, 0} : Vec3{});
    Affine place = translate(at);
    if (l.shape != Lamp::sphere && l.shape != Lamp::point)
        place = look_at(
            at,
            f.vector("target", at + Vec3{0, l.shape == Lamp::directional ? 0.0f : -1.0f, 0} -
                                   (l.shape == Lamp::directional ? at : Vec3{})),
            f.vector("up", {0, 1, 0}));
    if (l.shape == Lamp::quad) {
        const std::vector<float> size = f.numbers("size", 2, 2);
        const float w = size.empty() ? 1 : size[0], h = size.empty() ? 1 : size[1];
        if (w > 0 && h > 0)
            place = place * scale({0.5f * w, 0.5f * h, 1});
        else
            f.finding(value.find("size"), "'size' is not above 0");
    } else if (l.shape == Lamp::disc) {
        const float r = f.number("radius", 0.5f, 1e-6, 1e9);
        place = place * scale({r, r, 1});
    } else if (l.shape == Lamp::sphere) {
        place = place * scale(f.number("radius", 0.5f, 1e-6, 1e9));
    } else if (l.shape == Lamp::spot) {
        l.outer_cone = radians(f.number("cone", 45, 0.01, 90));
        l.inner_cone = std::min(radians(f.number("inner-cone", 0, 0, 90)), l.outer_cone);
    }
    if (l.area()) l.visible = f.flag("visible", true);
    l.to_world = moved(f, {place});
    f.end();
    scene.lights.push_back(std::move(l));
}

void JsonParts::environment(const Json& value) {
    JsonFields f(&value, "'environment'", findings);
    Environment& sky = scene.environment;
    sky = {};
    const Vec3 color = f.color("color", {1, 1, 1});
    sky.radiance = color * f.number("strength", 1, 0, 1e9);
    sky.rotation = radians(f.number("rotation", 0));
    sky.visible = f.flag("visible", true);
    const Json* at = f.any("file");
    f.end();
    if (!at) return;
    const std::string path = file(at, at->is(Json::Kind::text) ? at->text : "");
    if (path.empty()) return;
    PlainContext ctx;
    Image picture = read_picture(path);
    const std::string space = space_of(picture, "", ctx);
    if (space != scene.color_space)
        picture =
            apply_color(picture, ColorConfig::open("")->convert(space, scene.color_space), ctx);
    int rgb[3] = {picture.find("R"), picture.find("G"), picture.find("B")};
    if (rgb[0] < 0 || rgb[1] < 0 || rgb[2] < 0) rgb[0] = rgb[1] = rgb[2] = 0;
    auto map = std::make_shared<Image>(picture.width(), picture.height(), 3);
    map->color_space = scene.color_space;
    for (int y = 0; y < picture.height(); ++y)
        for (int x = 0; x < picture.width(); ++x)
            for (int c = 0; c < 3; ++c) {
                const float v = picture.at(x, y)[rgb[c]];
                map->at(x, y)[c] = v > 0 ? std::min(v, 1e6f) : 0.0f;  // NaN and negative: none
            }
    sky.map = std::move(map);
}

void JsonParts::shutter(const Json& value) {
    JsonFields f(&value, "'shutter'", findings);
    SceneCamera& c = scene.camera;
    c.shutter_open = f.number("open", c.shutter_open);
    c.shutter_close = f.number("close", c.shutter_close);
    if (c.shutter_close < c.shutter_open) {
        f.finding(&value, "the shutter closes before it opens");
        c.shutter_close = c.shutter_open;
    }
    if (f.has("curve")) c.shutter_curve = f.numbers("curve", 2, 1024);
    float sum = 0;
    for (const float open : c.shutter_curve) sum += open < 0 ? -1e9f : open;
    if (!c.shutter_curve.empty() && !(sum > 0)) {
        f.finding(value.find("curve"), "'curve' has numbers below 0, or none above");
        c.shutter_curve.clear();
    }
    f.end();
    seconds = c.shutter_close - c.shutter_open;
}

void JsonParts::camera(const Json& value) {
    JsonFields f(&value, "'camera'", findings);
    SceneCamera& c = scene.camera;
    c.name = f.text("name", c.name.empty() ? "camera" : c.name);
    Vec3 eye = c.to_world.front().origin, target = eye - c.to_world.front().z;
    const bool own = f.has("at") || f.has("target");
    eye = f.vector("at", eye), target = f.vector("target", target);
    const Vec3 up = f.vector("up", {0, 1, 0});
    if (own) c.to_world = {look_at(eye, target, up)};
    if (const Json* to = f.object("to")) {
        // Where it is when the shutter closes.
        JsonFields end(to, "'to'", findings);
        const Vec3 last = end.vector("at", eye);
        c.to_world = {c.to_world.front(),
                      look_at(last, end.vector("target", target), end.vector("up", up))};
        end.end();
    }
    const Vec3 velocity = f.vector("velocity", {}) * seconds;
    if (!(velocity == Vec3{})) {
        if (c.to_world.size() == 1) c.to_world.push_back(c.to_world.front());
        for (size_t i = 0; i < c.to_world.size(); ++i)
            c.to_world[i].origin += velocity * (float(i) / float(c.to_world.size() - 1));
    }
    c.vertical_fov = radians(f.number("fov", c.vertical_fov * 180 / pi, 0.01, 175));
    const float focus_default = own && f.has("target") ? length(target - eye) : c.focus;
    c.focus = f.number("focus", focus_default, 1e-6, 1e9);
    if (f.has("focus-at")) {
        const Affine& place = c.to_world.front();
        const float depth = dot(place.origin - f.vector("focus-at", {}), place.z);
        if (depth > 0)
            c.focus = depth;
        else
            f.finding(value.find("focus-at"), "'focus-at' lies behind the camera");
    }
    if (const Json* lens = f.object("lens")) {
        JsonFields l(lens, "'lens'", findings);
        if (l.has("radius") && l.has("f-number"))
            l.finding(lens, "'radius' and 'f-number' say the same; give one of them");
        c.lens_radius = l.number("radius", 0, 0, 1e6);
        // Sensor in millimetres; a thin lens's focal length by the field of view, focused far away.
        const float sensor = l.number("sensor", 24, 0.1, 1e4),
                    unit = l.number("meters-per-unit", 1, 1e-6, 1e6);
        if (l.has("f-number")) {
            const float focal = 0.5f * sensor / std::tan(0.5f * c.vertical_fov);
            c.lens_radius = 0.5f * focal / l.number("f-number", 8, 0.1, 1e4) * 1e-3f / unit;
        }
        const int blades = int(l.number("blades", 0, 0, 64));
        c.blades = blades;
        if (blades == 1 || blades == 2) {
            l.finding(lens->find("blades"), "'blades' is 1 or 2; expected 0 (round) or 3 to 64");
            c.blades = 0;
        }
        c.blade_rotation = radians(l.number("blade-rotation", 0));
        c.lens_aspect = l.number("squeeze", 1, 0.1, 10);
        l.end();
    }
    f.end();
}

}  // namespace weft
