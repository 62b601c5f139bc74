// Scenes from files: glTF 2.0 (.gltf, .glb), Wavefront OBJ (.obj with its .mtl), the JSON scene
// form (docs/scenes.md), and "procedural:NAME". Told apart by content, then by extension.
//   warnings  what was left out or taken otherwise, one sentence each
// Errors are weft::Error: file, element (mesh, accessor, material ...), what was found, what to do.
// What is returned has passed check_scene().
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "render/scene.h"

namespace weft {

struct SceneOptions {
    std::string camera;     // its name or number in the file; empty: the first
    std::string animation;  // glTF: the one to play, by name or number; empty: all, the first first
    float shutter_open = 0, shutter_close = 1.0f / 48;  // seconds of the animation
    std::uint64_t seed = 1;  // procedural: another arrangement
    float size = 1;          // procedural: how much there is in it
};

Scene read_scene_file(const std::string& path, const SceneOptions& options,
                      std::vector<std::string>& warnings);

// The parts, each from a file's bytes; `path` names it in messages and leads to what lies beside
// it.
Scene gltf_scene(const std::string& bytes, const std::string& path, const SceneOptions& options,
                 std::vector<std::string>& warnings);
Scene obj_scene(const std::string& bytes, const std::string& path, const SceneOptions& options,
                std::vector<std::string>& warnings);
Scene json_scene(const std::string& bytes, const std::string& path, const SceneOptions& options,
                 std::vector<std::string>& warnings);

// Every file that a scene reads, itself first, as far as they are there: what its key is made of.
std::vector<std::string> scene_files(const std::string& path);

// A camera that sees all of a scene, for files that have none.
SceneCamera camera_around(const Scene& scene);
// A dome of even light and a sun, for files that have no light at all.
void light_evenly(Scene& scene);

}  // namespace weft
