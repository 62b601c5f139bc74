// The JSON scene form (docs/scenes.md): other scene files placed and changed, shapes made by rule,
// lights, a lens and a shutter. Members are looked at in an order of their own: the shutter first,
// since speeds need it; then materials, what is included, shapes, lights, the camera.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "graph/error.h"
#include "image/picture_file.h"
#include "render/json_parts.h"
#include "render/scene_file.h"
#include "render/shapes.h"

namespace weft {
namespace {

constexpr size_t most_instances = 1000000;

// `pattern` may hold stars, each for any letters.
bool matches(std::string_view name, std::string_view pattern) {
    size_t n = 0, p = 0, star = std::string_view::npos, back = 0;
    while (n < name.size()) {
        if (p < pattern.size() && pattern[p] == '*')
            star = p++, back = n;
        else if (p < pattern.size() && pattern[p] == name[n])
            ++p, ++n;
        else if (star != std::string_view::npos)
            p = star + 1, n = ++back;
        else
            return false;
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

class Reader {
  public:
    Reader(const std::string& path, const SceneOptions& options, std::vector<std::string>& warnings)
        : path_(path),
          options_(options),
          warnings_(warnings),
          parts_{scene_, std::filesystem::path(path).parent_path().string(), findings_} {}

    Scene scene(const std::string& bytes, int depth) {
        depth_ = depth;
        const auto source = std::make_shared<const Source>(Source{path_, bytes});
        const Json document = parse_json(source, findings_);
        throw_findings(findings_);
        const Json* version = document.find("weft_scene");
        if (!version || !version->is(Json::Kind::number))
            throw Error(fmt::format("{}: not a scene: it has no \"weft_scene\": 1 (docs/scenes.md)",
                                    path_));
        if (version->number != 1)
            throw Error(fmt::format("{}: \"weft_scene\" is {}; this program reads 1",
                                    where(version->place), version->number));
        JsonFields f(&document, "a scene", findings_);
        f.any("weft_scene");
        f.any("about");
        scene_.name = f.text("name", path_), scene_.source = f.text("source", path_);
        scene_.camera.shutter_open = options_.shutter_open;
        scene_.camera.shutter_close = options_.shutter_close;
        const Json* shutter = f.object("shutter");
        if (shutter)
            parts_.shutter(*shutter);
        else
            parts_.seconds = options_.shutter_close - options_.shutter_open;
        const SceneCamera times = scene_.camera;
        if (const Json* all = f.object("materials"))
            for (const JsonMember& m : all->members)
                add_material(m.key, parts_.material(m.key, m.value));
        if (const Json* all = f.list("include"))
            for (const Json& item : all->items) include(item);
        if (const Json* all = f.list("shapes"))
            for (const Json& item : all->items) shape(item);
        if (const Json* all = f.list("lights"))
            for (const Json& item : all->items) parts_.light(item);
        if (const Json* sky = f.object("environment")) parts_.environment(*sky);
        const Json* camera = f.object("camera");
        scene_.camera.shutter_open = times.shutter_open,
        scene_.camera.shutter_close = times.shutter_close;
        scene_.camera.shutter_curve = times.shutter_curve;
        if (camera) parts_.camera(*camera);
        f.end();
        throw_findings(findings_);
        if (scene_.instances.empty() && scene_.lights.empty() && !scene_.environment.present())
            throw Error(
                fmt::format("{}: nothing to see: no 'include', no 'shapes', no 'lights'", path_));
        if (!has_camera_ && !(camera && camera->find("at"))) {
            warnings_.push_back(
                fmt::format("{}: it has no camera; one that sees all of it is taken", path_));
            const SceneCamera lens = scene_.camera;
            const SceneCamera around = camera_around(scene_);
            scene_.camera.to_world = around.to_world;
            if (!(camera && camera->find("fov"))) scene_.camera.vertical_fov = around.vertical_fov;
            if (!(camera && camera->find("focus"))) scene_.camera.focus = around.focus;
        }
        for (size_t i = 0; i < scene_.instances.size(); ++i)
            scene_.instances[i].id = std::uint32_t(i + 1);
        return std::move(scene_);
    }

  private:
    void add_material(const std::string& name, Material m) {
        materials_[name] = int(scene_.materials.size());
        scene_.materials.push_back(std::move(m));
    }

    int material(const Json* at) {
        if (!at->is(Json::Kind::text)) {
            findings_.push_back(
                {Diagnostic::Level::error,
                 fmt::format("'material' is {}; expected the name of one of 'materials'",
                             name_of(at->kind)),
                 at->place});
            return -1;
        }
        const auto found = materials_.find(at->text);
        if (found != materials_.end()) return found->second;
        std::vector<std::string> names;
        for (const auto& [name, index] : materials_) names.push_back(name);
        findings_.push_back(
            {Diagnostic::Level::error,
             fmt::format("no material '{}'{}", at->text, suggestion(at->text, names)), at->place});
        return -1;
    }

    struct Included {
        int first_mesh = 0, first_material = 0;
        Scene scene;  // without what has been moved over
    };

    Included* included(const std::string& path, const Json* at) {
        const auto known = included_.find(path);
        if (known != included_.end()) return &known->second;
        if (depth_ >= 8) {
            findings_.push_back({Diagnostic::Level::error,
                                 "files include one another more than 8 deep", at->place});
            return nullptr;
        }
        Included in;
        SceneOptions options = options_;
        options.shutter_open = scene_.camera.shutter_open,
        options.shutter_close = scene_.camera.shutter_close;
        std::vector<std::string> told;
        try {
            const std::string bytes = read_whole_file(path);
            if (path.ends_with(".json"))
                in.scene = Reader(path, options, told).scene(bytes, depth_ + 1);
            else if (path.ends_with(".obj") || path.ends_with(".OBJ")) {
                options.camera.clear();
                in.scene = obj_scene(bytes, path, options, told);
                in.scene.camera.name = "around";
            } else {
                in.scene = gltf_scene(bytes, path, options, told);
            }
        } catch (const Error& e) {
            findings_.push_back({Diagnostic::Level::error, e.what(), at->place});
            return nullptr;
        }
        for (const std::string& w : told)
            if (w.find("camera") == std::string::npos) warnings_.push_back(w);
        Scene& s = in.scene;
        in.first_mesh = int(scene_.meshes.size()), in.first_material = int(scene_.materials.size());
        const int first_texture = int(scene_.textures.size());
        for (TextureFile& t : s.textures) scene_.textures.push_back(std::move(t));
        for (Material& m : s.materials) {
            for (TextureMap* map : m.maps())
                if (map->used()) map->file += first_texture;
            scene_.materials.push_back(std::move(m));
        }
        for (Mesh& m : s.meshes) {
            m.material += in.first_material;
            scene_.meshes.push_back(std::move(m));
        }
        return &(included_[path] = std::move(in));
    }

    void include(const Json& value) {
        JsonFields f(&value, "an include", findings_);
        const Json* name = f.any("file");
        const std::string path =
            parts_.file(name ? name : &value, name && name->is(Json::Kind::text) ? name->text : "");
        const Affine at = f.placed();
        const std::string prefix = f.text("name");
        const bool lights = f.flag("lights", true), camera = f.flag("camera", true);
        const Json* all = f.any("material");
        const int instead = all ? material(all) : -1;
        const Json* overrides = f.object("override");
        std::vector<JsonMember> none;
        const std::vector<JsonMember>& changes = overrides ? overrides->members : none;
        Included* in = path.empty() ? nullptr : included(path, name);
        std::vector<bool> met(changes.size(), false);
        std::vector<std::string> names;
        if (in)
            for (Instance instance : in->scene.instances) {
                names.push_back(instance.name);
                if (!prefix.empty()) instance.name = prefix + "/" + instance.name;
                instance.mesh += in->first_mesh;
                if (instance.material >= 0) instance.material += in->first_material;
                for (Affine& key : instance.to_world) key = at * key;
                if (instead >= 0) instance.material = instead;
                bool hidden = false;
                for (size_t i = 0; i < changes.size(); ++i)
                    if (matches(names.back(), changes[i].key)) {
                        met[i] = true;
                        hidden |= changed(changes[i], instance);
                    }
                if (hidden) continue;
                instance.to_world = moved_whole(f, std::move(instance.to_world), at.origin);
                scene_.instances.push_back(std::move(instance));
            }
        else
            f.any("velocity"), f.any("spin");
        f.any("velocity"), f.any("spin");
        for (size_t i = 0; i < changes.size() && in; ++i)
            if (!met[i])
                findings_.push_back({Diagnostic::Level::error,
                                     fmt::format("no part '{}' in it{}", changes[i].key,
                                                 suggestion(changes[i].key, names)),
                                     changes[i].key_place});
        f.end();
        if (!in) return;
        if (lights)
            for (Light light : in->scene.lights) {
                for (Affine& key : light.to_world) key = at * key;
                scene_.lights.push_back(std::move(light));
            }
        if (lights && in->scene.environment.present()) scene_.environment = in->scene.environment;
        if (camera && !has_camera_ && in->scene.camera.name != "around") {
            has_camera_ = true;
            scene_.camera = in->scene.camera;
            for (Affine& key : scene_.camera.to_world) key = rigid(at * key);
        }
    }

    // An include moves as one: it turns about its own origin.
    std::vector<Affine> moved_whole(JsonFields& f, std::vector<Affine> keys, Vec3 about) {
        if (!f.has("velocity") && !f.has("spin")) return keys;
        if (keys.size() > 1 || !f.has("spin")) return parts_.moved(f, std::move(keys));
        const std::vector<Affine> whole = parts_.moved(f, {translate(about)});
        std::vector<Affine> out;
        for (const Affine& w : whole) out.push_back(w * translate(-about) * keys[0]);
        return out;
    }

    // Returns whether it is hidden.
    bool changed(const JsonMember& change, Instance& instance) {
        JsonFields f(&change.value, fmt::format("the override of '{}'", change.key), findings_);
        if (const Json* m = f.any("material")) instance.material = material(m);
        instance.to_world = parts_.moved(f, std::move(instance.to_world));
        const bool hidden = f.flag("hide", false);
        f.end();
        return hidden;
    }

    void shape(const Json& value) {
        JsonFields f(&value, "a shape", findings_);
        static const std::vector<std::string> names = {"plane", "wall", "sphere",
                                                       "disc",  "cube", "torus"};
        if (!f.has("shape"))
            f.finding(&value,
                      fmt::format("a shape has no 'shape'; known: {}", fmt::join(names, ", ")));
        const size_t kind = f.choice("shape", names, 0);
        const int segments = int(f.number("segments", 64, 3, 512));
        const float tube = f.number("tube", 0.25f, 0.001, 1);
        const Json* named_material = f.any("material");
        int with = named_material ? material(named_material) : -1;
        if (with < 0) {
            if (plain_ < 0) {
                plain_ = int(scene_.materials.size());
                Material m;
                m.name = "plain";
                scene_.materials.push_back(m);
            }
            with = plain_;
        }
        Instance instance;
        instance.name = f.text("name", names[kind]);
        instance.material = with;
        const auto [known, fresh] =
            shapes_.try_emplace({kind, segments, tube}, int(scene_.meshes.size()));
        if (fresh) {
            Mesh mesh = kind == 0   ? plane_mesh()
                        : kind == 1 ? wall_mesh()
                        : kind == 2 ? sphere_mesh(segments)
                        : kind == 3 ? disc_mesh(segments)
                        : kind == 4 ? cube_mesh()
                                    : torus_mesh(tube, segments);
            mesh.name = names[kind], mesh.material = with;
            scene_.meshes.push_back(std::move(mesh));
        }
        instance.mesh = known->second;
        const Affine at = f.placed();
        const std::vector<Affine> keys = parts_.moved(f, {at});
        int count[3] = {1, 1, 1};
        Vec3 step{};
        if (const Json* grid = f.object("grid")) {
            JsonFields g(grid, "'grid'", findings_);
            const std::vector<float> n = g.numbers("count", 3, 3);
            double total = 1;
            for (size_t i = 0; i < n.size(); ++i) {
                count[i] = int(std::clamp(n[i], 1.0f, 4e6f));
                total *= count[i];
            }
            step = g.vector("step", {1, 1, 1});
            g.end();
            if (total + double(scene_.instances.size()) > most_instances) {
                g.finding(grid, fmt::format("{} more instances; a scene holds {} at most", total,
                                            most_instances));
                count[0] = count[1] = count[2] = 1;
            }
        }
        f.end();
        for (int z = 0; z < count[2]; ++z)
            for (int y = 0; y < count[1]; ++y)
                for (int x = 0; x < count[0]; ++x) {
                    const Vec3 shift{step.x * (float(x) - 0.5f * float(count[0] - 1)),
                                     step.y * (float(y) - 0.5f * float(count[1] - 1)),
                                     step.z * (float(z) - 0.5f * float(count[2] - 1))};
                    instance.to_world = keys;
                    for (Affine& key : instance.to_world) key.origin += shift;
                    scene_.instances.push_back(instance);
                }
    }

    const std::string& path_;
    const SceneOptions& options_;
    std::vector<std::string>& warnings_;
    std::vector<Diagnostic> findings_;
    Scene scene_;
    JsonParts parts_;
    int depth_ = 0, plain_ = -1;
    bool has_camera_ = false;
    std::map<std::string, int> materials_;
    std::map<std::string, Included> included_;
    std::map<std::tuple<size_t, int, float>, int> shapes_;
};

}  // namespace

Scene json_scene(const std::string& bytes, const std::string& path, const SceneOptions& options,
                 std::vector<std::string>& warnings) {
    return Reader(path, options, warnings).scene(bytes, 0);
}

}  // namespace weft
