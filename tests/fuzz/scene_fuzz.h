// What the fuzzers of scene readers and the replay of their corpora do with one input: a sound
// scene is made of it, or it is refused with a message that names the file.
#pragma once
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "graph/error.h"
#include "render/check_scene.h"
#include "render/scene_file.h"

namespace weft::test {

using SceneReader = Scene (*)(const std::string&, const std::string&, const SceneOptions&,
                              std::vector<std::string>&);

inline void fuzz_scene(SceneReader read, std::string_view input, const char* file) {
    std::vector<std::string> warnings;
    Scene scene;
    try {
        scene = read(std::string(input), file, {"", "", 0, 0.5f}, warnings);
    } catch (const Error& error) {
        if (std::string_view(error.what()).find("input") == std::string_view::npos) {
            std::fprintf(stderr, "refused without its name: %s\n", error.what());
            std::abort();
        }
        return;
    }
    try {
        check_scene(scene);
    } catch (const Error&) {  // read_scene_file() looks, and names the file
    }
}
inline void fuzz_gltf(std::string_view input) {
    fuzz_scene(gltf_scene, input, "input.gltf");
}
inline void fuzz_obj(std::string_view input) {
    fuzz_scene(obj_scene, input, "input.obj");
}
struct TemporaryFolder {
    std::string path = (std::filesystem::temp_directory_path() / "weft-fuzz-XXXXXX").string();
    TemporaryFolder() {
        if (!mkdtemp(path.data())) std::abort();
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path); }
};
// The input is the material file of a square; it can name itself as a picture, which is there.
inline void fuzz_mtl(std::string_view input) {
    static const TemporaryFolder folder;
    const std::string file = folder.path + "/input.mtl";
    std::ofstream(file, std::ios::binary) << input;
    fuzz_scene(obj_scene,
               "mtllib input.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nusemtl all\nf 1/1 2/1 3/1\n",
               (folder.path + "/input.obj").c_str());
    std::filesystem::remove(file);
}
inline void fuzz_json_scene(std::string_view input) {
    fuzz_scene(json_scene, input, "input.json");
}

}  // namespace weft::test
