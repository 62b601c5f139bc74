// glTF 2.0 -> Scene: the node hierarchy flattened into instances (Embree has one level of them),
// every primitive a mesh that its nodes share. Nodes that move over the shutter get motion keys,
// skinned and morphed meshes a mesh of their own with the vertices at both its ends.
// Light units: candela, lux and nit are taken as W/sr, W/m2 and W/(sr m2): one unit for all.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "graph/diagnostic.h"
#include "graph/error.h"
#include "render/check_scene.h"
#include "render/gltf_animation.h"
#include "render/gltf_materials.h"
#include "render/gltf_meshes.h"
#include "render/motion_keys.h"
#include "render/scene_file.h"
#include "render/shapes.h"

namespace weft {
namespace {

constexpr int samples = 16;  // of a movement over the shutter, besides its start

class Reader {
  public:
    Reader(const std::string& bytes, const std::string& path, const SceneOptions& options,
           std::vector<std::string>& warnings)
        : file_(bytes, path),
          model_(file_.model()),
          options_(options),
          warnings_(warnings),
          poses_(file_, options.animation) {}

    Scene scene() {
        if (const auto unread = file_.unread_extensions(); !unread.empty())
            warnings_.push_back(
                fmt::format("{}: extensions that are not read: {}; it is as it is "
                            "without them",
                            file_.path(), fmt::join(unread, ", ")));
        uv_sets_ = add_gltf_materials(file_, scene_, warnings_);
        place_nodes();
        for (const size_t node : order_) {
            const auto& n = model_.nodes[node];
            if (n.mesh >= 0) add_mesh(node);
            if (n.camera >= 0) add_camera(node);
            add_light(node);
        }
        choose_camera();
        scene_.name = file_.path();
        scene_.source =
            fmt::format("{}{}{}", file_.path(), model_.asset.copyright.empty() ? "" : ", ",
                        model_.asset.copyright);
        return std::move(scene_);
    }

  private:
    std::string named(size_t node) const {
        const std::string& name = model_.nodes[node].name;
        return name.empty() ? fmt::format("node {}", node)
                            : fmt::format("node {} ('{}')", node, name);
    }

    // Where every node stands at every sample of the shutter, parents first.
    void place_nodes() {
        const size_t count = model_.nodes.size();
        std::vector<int> parent(count, -1);
        for (size_t i = 0; i < count; ++i)
            for (const int child : model_.nodes[i].children) {
                const size_t c = file_.index(child, count, named(i), "child");
                if (c == i) file_.fail(named(c), "it is its own child");
                if (parent[c] >= 0)
                    file_.fail(named(c),
                               fmt::format("it is a child of nodes {} and {}; a node has one "
                                           "parent",
                                           parent[c], i));
                parent[c] = int(i);
            }
        std::vector<size_t> open;
        if (model_.scenes.empty()) {
            for (size_t i = 0; i < count; ++i)
                if (parent[i] < 0) open.push_back(i);
        } else {
            const size_t chosen = model_.defaultScene < 0
                                      ? 0
                                      : file_.index(model_.defaultScene, model_.scenes.size(),
                                                    "its default scene", "scene");
            for (const int node : model_.scenes[chosen].nodes)
                open.push_back(file_.index(node, count, fmt::format("scene {}", chosen), "node"));
        }
        std::reverse(open.begin(), open.end());
        std::vector<bool> seen(count, false);
        world_.resize(count);
        const bool still = !poses_.animated() || !(options_.shutter_close > options_.shutter_open);
        times_.clear();
        for (int i = 0; i <= (still ? 0 : samples); ++i)
            times_.push_back(options_.shutter_open +
                             (options_.shutter_close - options_.shutter_open) * float(i) / samples);
        if (!still) times_.back() = options_.shutter_close;  // without rounding
        while (!open.empty()) {
            const size_t node = open.back();
            open.pop_back();
            if (seen[node])
                file_.fail(named(node), "it is its own ancestor, or stands in the scene twice");
            seen[node] = true;
            order_.push_back(node);
            for (size_t t = 0; t < times_.size(); ++t) {
                const Affine local = poses_.at(node, times_[t]).local();
                const int up = parent[node];
                world_[node].push_back(up >= 0 && seen[size_t(up)] ? world_[size_t(up)][t] * local
                                                                   : local);
                if (!finite(world_[node].back()))
                    file_.fail(named(node), "its place is not finite");
            }
            const auto& children = model_.nodes[node].children;
            for (size_t i = children.size(); i-- > 0;) open.push_back(size_t(children[i]));
        }
    }

    const GltfPrimitive& primitive(size_t mesh, size_t part) {
        const auto known = primitives_.find({mesh, part});
        if (known != primitives_.end()) return known->second;
        return primitives_[{mesh, part}] = gltf_primitive(file_, mesh, part, uv_sets_, warnings_);
    }

    void add_mesh(size_t node) {
        const auto& n = model_.nodes[node];
        const size_t mesh = file_.index(n.mesh, model_.meshes.size(), named(node), "mesh");
        for (size_t part = 0; part < model_.meshes[mesh].primitives.size(); ++part) {
            const GltfPrimitive& p = primitive(mesh, part);
            if (p.mesh.triangles.empty()) continue;
            const bool skinned = n.skin >= 0 && !p.joints.empty();
            const bool morphed = !p.morph_positions.empty();
            if (skinned || morphed) {
                const int own = add(deformed(node, p, skinned));
                place(node, own,
                      skinned ? std::vector<Affine>{Affine{}} : fewest_keys(world_[node]));
                continue;
            }
            auto [known, fresh] = shared_.try_emplace({mesh, part}, -1);
            if (fresh) known->second = add(p.mesh);
            place(node, known->second, fewest_keys(world_[node]));
        }
    }

    Mesh deformed(size_t node, const GltfPrimitive& p, bool skinned) {
        std::vector<size_t> ends = {0};
        if (times_.size() > 1) ends.push_back(times_.size() - 1);
        std::vector<std::vector<float>> weights;
        std::vector<std::vector<Affine>> joints;
        for (const size_t t : ends) {
            weights.push_back(poses_.at(node, times_[t]).weights);
            joints.push_back(skinned ? joints_at(node, t) : std::vector<Affine>{});
        }
        return posed(file_, p, weights, joints, named(node));
    }

    std::vector<Affine> joints_at(size_t node, size_t t) {
        const auto& n = model_.nodes[node];
        const size_t skin = file_.index(n.skin, model_.skins.size(), named(node), "skin");
        const auto& s = model_.skins[skin];
        const std::string what = fmt::format("skin {}", skin);
        std::vector<float> bind;
        if (s.inverseBindMatrices >= 0) {
            bind = file_.numbers(s.inverseBindMatrices, 16, what);
            if (bind.size() < 16 * s.joints.size())
                file_.fail(what, fmt::format("{} inverse bind matrices for {} joints",
                                             bind.size() / 16, s.joints.size()));
        }
        std::vector<Affine> all;
        for (size_t i = 0; i < s.joints.size(); ++i) {
            const size_t joint = file_.index(s.joints[i], model_.nodes.size(), what, "joint");
            if (world_[joint].empty())
                file_.fail(what, fmt::format("joint {} is not in the scene", joint));
            Affine m = world_[joint][t];
            if (!bind.empty()) {
                const float* b = bind.data() + 16 * i;
                m = m * Affine{{b[0], b[1], b[2]},
                               {b[4], b[5], b[6]},
                               {b[8], b[9], b[10]},
                               {b[12], b[13], b[14]}};
            }
            all.push_back(m);
        }
        return all;
    }

    int add(Mesh mesh) {
        scene_.meshes.push_back(std::move(mesh));
        return int(scene_.meshes.size()) - 1;
    }

    void place(size_t node, int mesh, std::vector<Affine> keys) {
        if (!std::all_of(keys.begin(), keys.end(), is_invertible)) {
            // Flattened to a plane or less: the vertices take it.
            if (keys.size() > 1) {
                warnings_.push_back(
                    fmt::format("{}: {}: it shrinks to nothing while it moves; left out",
                                file_.path(), named(node)));
                return;
            }
            Mesh flat = scene_.meshes[size_t(mesh)];
            for (Vec3& p : flat.positions) p = keys[0].point(p);
            flat.normals.clear();
            mesh = add(std::move(flat));
            keys = {Affine{}};
        }
        Instance instance;
        instance.name = model_.nodes[node].name.empty() ? fmt::format("node {}", node)
                                                        : model_.nodes[node].name;
        instance.mesh = mesh;
        instance.to_world = std::move(keys);
        instance.id = std::uint32_t(scene_.instances.size() + 1);
        scene_.instances.push_back(std::move(instance));
    }

    std::vector<Affine> rigid_keys(size_t node) const {
        std::vector<Affine> keys = world_[node];
        for (Affine& key : keys) key = rigid(key);
        return fewest_keys(keys);
    }

    void add_camera(size_t node) {
        const size_t index =
            file_.index(model_.nodes[node].camera, model_.cameras.size(), named(node), "camera");
        const auto& c = model_.cameras[index];
        SceneCamera camera;
        camera.name = !c.name.empty() ? c.name : model_.nodes[node].name;
        camera.to_world = rigid_keys(node);
        if (c.type == "orthographic") {
            warnings_.push_back(
                fmt::format("{}: camera {} ('{}') is orthographic; one of 40 degrees is "
                            "taken in its place",
                            file_.path(), index, camera.name));
            camera.vertical_fov = radians(40);
        } else {
            camera.vertical_fov = float(c.perspective.yfov);
            if (!(camera.vertical_fov > 0 && camera.vertical_fov < pi))
                file_.fail(fmt::format("camera {} ('{}')", index, camera.name),
                           fmt::format("yfov is {}; expected more than 0 and less than pi",
                                       c.perspective.yfov));
        }
        camera.shutter_open = options_.shutter_open, camera.shutter_close = options_.shutter_close;
        cameras_.push_back(std::move(camera));
    }

    void choose_camera() {
        std::vector<std::string> names;
        for (const SceneCamera& c : cameras_) names.push_back(c.name);
        const std::string& wanted = options_.camera;
        size_t chosen = size_t(std::find(names.begin(), names.end(), wanted) - names.begin());
        if (wanted.empty())
            chosen = 0;
        else if (chosen == names.size()) {
            const auto [end, error] =
                std::from_chars(wanted.data(), wanted.data() + wanted.size(), chosen);
            if (error != std::errc() || end != wanted.data() + wanted.size() ||
                chosen >= names.size())
                file_.fail(
                    fmt::format("camera '{}'", wanted),
                    fmt::format("the file has no such camera{}",
                                names.empty() ? ", nor any other" : suggestion(wanted, names)));
        }
        if (chosen < cameras_.size()) {
            scene_.camera = cameras_[chosen];
            return;
        }
        warnings_.push_back(
            fmt::format("{}: it has no camera; one that sees all of it is taken", file_.path()));
        scene_.camera = camera_around(scene_);
        scene_.camera.shutter_open = options_.shutter_open;
        scene_.camera.shutter_close = options_.shutter_close;
    }

    void add_light(size_t node) {
        const auto found = model_.nodes[node].extensions.find("KHR_lights_punctual");
        if (found == model_.nodes[node].extensions.end() || !found->second.IsObject() ||
            !found->second.Has("light") || !found->second.Get("light").IsNumber())
            return;
        const double given = found->second.Get("light").GetNumberAsDouble();
        const int number = given >= 0 && given < 1e9 ? int(given) : -1;
        const auto& l =
            model_.lights[file_.index(number, model_.lights.size(), named(node), "light")];
        const std::string what = fmt::format("light {} ('{}')", number, l.name);
        Light light;
        light.name = !l.name.empty() ? l.name : model_.nodes[node].name;
        Vec3 color{1, 1, 1};
        if (l.color.size() >= 3) color = {float(l.color[0]), float(l.color[1]), float(l.color[2])};
        light.radiance = color * float(l.intensity);
        if (!finite(light.radiance) || light.radiance.x < 0 || light.radiance.y < 0 ||
            light.radiance.z < 0)
            file_.fail(what, "its colour or intensity is negative or not finite");
        if (l.type == "point")
            light.shape = Light::Shape::point;
        else if (l.type == "directional")
            light.shape = Light::Shape::directional;
        else if (l.type == "spot") {
            light.shape = Light::Shape::spot;
            light.inner_cone = float(l.spot.innerConeAngle),
            light.outer_cone = float(l.spot.outerConeAngle);
            if (!(light.inner_cone >= 0 && light.outer_cone >= light.inner_cone &&
                  light.outer_cone <= pi))
                file_.fail(what,
                           fmt::format("cones of {} and {}; expected 0 <= inner <= outer <= pi/2",
                                       l.spot.innerConeAngle, l.spot.outerConeAngle));
        } else {
            file_.fail(what, fmt::format("type '{}'; known: point, spot, directional", l.type));
        }
        light.to_world = rigid_keys(node);
        scene_.lights.push_back(std::move(light));
    }

    GltfFile file_;
    const tinygltf::Model& model_;
    const SceneOptions& options_;
    std::vector<std::string>& warnings_;
    GltfPoses poses_;
    Scene scene_;
    std::vector<GltfUvSets> uv_sets_;
    std::vector<size_t> order_;
    std::vector<std::vector<Affine>> world_;
    std::vector<float> times_;
    std::map<std::pair<size_t, size_t>, GltfPrimitive> primitives_;
    std::map<std::pair<size_t, size_t>, int> shared_;
    std::vector<SceneCamera> cameras_;
};

}  // namespace

Scene gltf_scene(const std::string& bytes, const std::string& path, const SceneOptions& options,
                 std::vector<std::string>& warnings) {
    Scene scene = Reader(bytes, path, options, warnings).scene();
    if (scene.instances.empty())
        throw Error(fmt::format("{}: nothing to see: no node has a mesh", path));
    return scene;
}

}  // namespace weft
