// The parts of the JSON scene form that stand alone: materials, lights, camera, environment.
// What is wrong becomes a finding; what is returned can be used all the same.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "render/json_fields.h"
#include "render/scene.h"

namespace weft {

struct JsonParts {
    Scene& scene;
    std::string folder;  // files are named from here
    std::vector<Diagnostic>& findings;
    float seconds = 0;  // the shutter is open
    std::map<std::pair<std::string, bool>, int> textures = {};

    // The file's path; a finding where there is none.
    std::string file(const Json* at, const std::string& name) const;
    TextureMap map(JsonFields& from, std::string_view key, bool color);
    Material material(const std::string& name, const Json& value);
    void light(const Json& value);
    void environment(const Json& value);
    void camera(const Json& value);
    void shutter(const Json& value);
    // "velocity" (units a second) and "spin" {"axis", "turns" a second} of something at `keys`.
    std::vector<Affine> moved(JsonFields& from, std::vector<Affine> keys);
};

}  // namespace weft
