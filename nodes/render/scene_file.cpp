#include "render/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "graph/error.h"
#include "image/picture_file.h"
#include "render/affine.h"
#include "render/check_scene.h"
#include "render/procedural_scene.h"

namespace weft {
namespace {

struct Box {
    Vec3 low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
    void add(Vec3 p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
};

Box bounds(const Scene& scene) {
    std::vector<Box> meshes(scene.meshes.size());
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        for (const Vec3 p : scene.meshes[i].positions) meshes[i].add(p);
    Box all;
    for (const Instance& instance : scene.instances) {
        const Box& b = meshes[size_t(instance.mesh)];
        if (!(b.low.x <= b.high.x)) continue;
        for (int corner = 0; corner < 8; ++corner)
            all.add(instance.to_world.front().point({corner & 1 ? b.high.x : b.low.x,
                                                     corner & 2 ? b.high.y : b.low.y,
                                                     corner & 4 ? b.high.z : b.low.z}));
    }
    if (!(all.low.x <= all.high.x) || !finite(all.low) || !finite(all.high)) {
        all = {};
        all.add({-1, -1, -1}), all.add({1, 1, 1});
    }
    return all;
}

std::string lower_extension(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    return extension;
}

}  // namespace

SceneCamera camera_around(const Scene& scene) {
    const Box box = bounds(scene);
    const Vec3 middle = (box.low + box.high) * 0.5f;
    const float radius = std::max(0.5f * length(box.high - box.low), 1e-6f);
    SceneCamera camera;
    camera.name = "around";
    camera.vertical_fov = radians(40);
    const float away = radius / std::sin(0.5f * camera.vertical_fov);
    const Vec3 eye = middle + unit(Vec3{0.35f, 0.25f, 1}) * away;
    camera.to_world = {look_at(eye, middle)};
    camera.focus = away;
    return camera;
}

void light_evenly(Scene& scene) {
    scene.environment.radiance = {0.6f, 0.65f, 0.75f};
    Light sun;
    sun.name = "sun", sun.shape = Light::Shape::directional;
    sun.radiance = {2.4f, 2.2f, 1.9f};
    sun.to_world = {look_at({0.5f, 1, 0.6f}, {0, 0, 0})};
    scene.lights.push_back(sun);
}

Scene read_scene_file(const std::string& path, const SceneOptions& options,
                      std::vector<std::string>& warnings) {
    constexpr std::string_view procedural = "procedural:";
    if (path.starts_with(procedural)) {
        if (!options.camera.empty() || !options.animation.empty())
            throw Error(
                fmt::format("{}: 'camera' and 'animation' choose among a file's; a scene "
                            "made by rule has one camera and moves as it does: leave them "
                            "empty",
                            path));
        return procedural_scene(path.substr(procedural.size()), options.seed, options.size);
    }
    if (options.seed != 1 || options.size != 1)
        throw Error(
            fmt::format("{}: 'seed' and 'size' make procedural:NAME scenes; a file is as it "
                        "is: leave them at 1",
                        path));
    std::error_code none;
    if (!std::filesystem::exists(path, none)) {
        const bool fetched = path.find("scenes/") != std::string::npos;
        throw Error(fmt::format(
            "{}: no such scene file{}", path,
            fetched ? "; tools/scenes fetches the scenes that are not made by rule" : ""));
    }
    const std::string bytes = read_whole_file(path), extension = lower_extension(path);
    const size_t first = bytes.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    const bool json = first != std::string::npos && (bytes[first] == '{' || bytes[first] == '/');
    Scene scene;
    if (bytes.starts_with("glTF") || extension == ".gltf" || extension == ".glb")
        scene = gltf_scene(bytes, path, options, warnings);
    else if (extension == ".json" || (json && extension != ".obj"))
        scene = json_scene(bytes, path, options, warnings);
    else if (extension == ".obj")
        scene = obj_scene(bytes, path, options, warnings);
    else
        throw Error(
            fmt::format("{}: not a scene that can be read; expected glTF (.gltf, .glb), Wavefront "
                        "(.obj), a JSON scene (.json) or procedural:NAME",
                        path));
    const bool lit = !scene.lights.empty() || scene.environment.present() ||
                     std::any_of(scene.materials.begin(), scene.materials.end(),
                                 [](const Material& m) { return m.emits(); });
    if (!lit) {
        warnings.push_back(
            fmt::format("{}: it has no light; an even sky and a sun are taken", path));
        light_evenly(scene);
    }
    try {
        check_scene(scene);
    } catch (const Error& e) {
        throw Error(fmt::format("{}: {}", path, e.what()));
    }
    return scene;
}

}  // namespace weft
