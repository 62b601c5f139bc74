#include "render/check_scene.h"

#include <fmt/format.h>

#include <cmath>

#include "graph/error.h"
#include "render/affine.h"

namespace weft {
namespace {

std::string named(const char* what, size_t i, const std::string& name) {
    return name.empty() ? fmt::format("{} {}", what, i)
                        : fmt::format("{} {} ('{}')", what, i, name);
}

void require(bool good, const std::string& what, const std::string& why) {
    if (!good) throw Error(fmt::format("{}: {}", what, why));
}

void check_keys(const std::vector<Affine>& keys, const std::string& what) {
    require(!keys.empty(), what, "has no place");
    require(keys.size() <= most_motion_keys, what,
            fmt::format("has {} motion keys; at most {} work", keys.size(), most_motion_keys));
    for (const Affine& key : keys) require(finite(key), what, "its place is not finite");
}

bool color(Vec3 c) {
    return finite(c) && c.x >= 0 && c.y >= 0 && c.z >= 0;
}

void check_map(const TextureMap& map, const Scene& scene, const std::string& what) {
    require(map.file < int(scene.textures.size()), what,
            fmt::format("texture {} of {}", map.file, scene.textures.size()));
    require(std::isfinite(map.offset.x) && std::isfinite(map.offset.y) &&
                std::isfinite(map.scale.x) && std::isfinite(map.scale.y) &&
                std::isfinite(map.rotation),
            what, "a texture's place is not finite");
    require(map.uv_set == 0 || map.uv_set == 1, what,
            fmt::format("a texture reads set {} of texture coordinates; there are 0 and 1",
                        map.uv_set));
}

void check_material(const Material& m, const Scene& scene, const std::string& what) {
    require(color(m.base_color), what, "base colour is negative or not finite");
    require(color(m.emission), what, "emission is negative or not finite");
    const auto part = [&](float value, const char* name) {
        require(value >= 0 && value <= 1, what,
                fmt::format("{} is {}; expected 0 to 1", name, value));
    };
    part(m.metallic, "metallic"), part(m.roughness, "roughness");
    part(m.transmission, "transmission"), part(m.opacity, "opacity");
    require(m.ior >= 1 && m.ior <= 10, what, fmt::format("ior is {}; expected 1 to 10", m.ior));
    require(std::isfinite(m.alpha_cutoff) && std::isfinite(m.normal_scale), what,
            "alpha cutoff or normal scale is not finite");
    for (const TextureMap* map : m.maps()) check_map(*map, scene, what);
}

void check_mesh(const Mesh& mesh, const Scene& scene, const std::string& what) {
    require(mesh.steps >= 1 && mesh.positions.size() % size_t(mesh.steps) == 0, what,
            fmt::format("{} positions in {} keys", mesh.positions.size(), mesh.steps));
    require(size_t(mesh.steps) <= most_motion_keys, what,
            fmt::format("has {} motion keys; at most {} work", mesh.steps, most_motion_keys));
    require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(), what,
            fmt::format("{} normals for {} positions", mesh.normals.size(), mesh.positions.size()));
    for (const auto* uv : {&mesh.uv, &mesh.uv2}) {
        require(uv->empty() || uv->size() == mesh.vertices(), what,
                fmt::format("{} uv for {} vertices", uv->size(), mesh.vertices()));
        for (size_t i = 0; i < uv->size(); ++i)
            require(std::isfinite((*uv)[i].x) && std::isfinite((*uv)[i].y), what,
                    fmt::format("uv {} is not finite", i));
    }
    require(mesh.material >= 0 && mesh.material < int(scene.materials.size()), what,
            fmt::format("material {} of {}", mesh.material, scene.materials.size()));
    for (size_t i = 0; i < mesh.positions.size(); ++i)
        require(finite(mesh.positions[i]), what, fmt::format("position {} is not finite", i));
    for (size_t i = 0; i < mesh.normals.size(); ++i)
        require(std::fabs(dot(mesh.normals[i], mesh.normals[i]) - 1) < 1e-3f, what,
                fmt::format("normal {} is not unit", i));
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
        for (const std::uint32_t v : mesh.triangles[i])
            require(v < mesh.vertices(), what,
                    fmt::format("triangle {} names vertex {} of {}", i, v, mesh.vertices()));
}

void check_camera(const SceneCamera& c) {
    const std::string what = c.name.empty() ? "camera" : fmt::format("camera '{}'", c.name);
    check_keys(c.to_world, what);
    for (const Affine& key : c.to_world)
        require(std::fabs(dot(key.x, key.x) - 1) < 1e-3f &&
                    std::fabs(dot(key.y, key.y) - 1) < 1e-3f &&
                    std::fabs(determinant(key) - 1) < 1e-2f,
                what, "its place is more than a rotation and a translation");
    require(c.vertical_fov > 0 && c.vertical_fov < pi, what,
            fmt::format("vertical field of view {} degrees; expected more than 0 and less than 180",
                        c.vertical_fov * 180 / pi));
    require(c.lens_radius >= 0 && std::isfinite(c.lens_radius), what, "lens radius is negative");
    require(c.focus > 0 && std::isfinite(c.focus), what, "focus distance is not above 0");
    require(c.lens_aspect > 0 && std::isfinite(c.lens_aspect), what, "lens aspect is not above 0");
    require(c.blades == 0 || (c.blades >= 3 && c.blades <= 64), what,
            fmt::format("{} blades; expected 0 (round) or 3 to 64", c.blades));
    require(std::isfinite(c.blade_rotation), what, "blade rotation is not finite");
    require(std::isfinite(c.shutter_open) && std::isfinite(c.shutter_close), what,
            "the shutter's times are not finite");
    float sum = 0;
    for (const float open : c.shutter_curve) {
        require(open >= 0 && std::isfinite(open), what, "the shutter curve is negative");
        sum += open;
    }
    require(c.shutter_curve.empty() || (c.shutter_curve.size() > 1 && sum > 0), what,
            "the shutter curve needs two values, one of them above 0");
}

}  // namespace

void check_scene(const Scene& scene) {
    for (size_t i = 0; i < scene.materials.size(); ++i)
        check_material(scene.materials[i], scene, named("material", i, scene.materials[i].name));
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        check_mesh(scene.meshes[i], scene, named("mesh", i, scene.meshes[i].name));
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const std::string what = named("instance", i, instance.name);
        check_keys(instance.to_world, what);
        require(instance.mesh >= 0 && instance.mesh < int(scene.meshes.size()), what,
                fmt::format("mesh {} of {}", instance.mesh, scene.meshes.size()));
        require(instance.material < int(scene.materials.size()), what,
                fmt::format("material {} of {}", instance.material, scene.materials.size()));
    }
    for (size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        const std::string what = named("light", i, light.name);
        check_keys(light.to_world, what);
        require(color(light.radiance), what, "radiance is negative or not finite");
        require(
            light.inner_cone >= 0 && light.outer_cone >= light.inner_cone && light.outer_cone <= pi,
            what, "its cones are not 0 <= inner <= outer <= 180 degrees");
    }
    const Environment& sky = scene.environment;
    require(color(sky.radiance) && std::isfinite(sky.rotation), "environment",
            "radiance is negative or not finite");
    if (sky.map) {
        require(sky.map->width() > 0 && sky.map->height() > 0 && sky.map->channels() >= 3,
                "environment", "its map has no RGB pixels");
        for (const float value : sky.map->pixels())
            require(std::isfinite(value) && value >= 0, "environment",
                    "its map has pixels that are negative or not finite");
    }
    check_camera(scene.camera);
}

}  // namespace weft
