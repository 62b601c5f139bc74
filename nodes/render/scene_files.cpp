// Which files a scene is made of, found without reading the scene: every text in it that names a
// file beside it. A name too many costs a hash; one too few would let a changed scene keep its key.
#include <algorithm>
#include <filesystem>
#include <set>

#include "graph/diagnostic.h"
#include "graph/error.h"
#include "image/picture_file.h"
#include "render/gltf_file.h"
#include "render/scene_file.h"

namespace weft {
namespace {

namespace fs = std::filesystem;

class Finder {
  public:
    std::vector<std::string> found;

    void file(const fs::path& path) {
        std::error_code none;
        if (found.size() > 100000 || !fs::is_regular_file(path, none)) return;
        const std::string name = path.lexically_normal().string();
        if (!seen_.insert(name).second) return;
        found.push_back(name);
        std::string extension = path.extension().string();
        for (char& c : extension) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
        const fs::path folder = path.parent_path();
        if (extension == ".gltf" || extension == ".json") {
            std::vector<Diagnostic> ignored;
            texts(parse_json(std::make_shared<const Source>(Source{name, read_whole_file(name)}),
                             ignored),
                  folder);
        } else if (extension == ".glb") {
            const std::string bytes = read_whole_file(name);
            if (bytes.size() < 20) return;
            const size_t end =
                bytes.find_last_of('}', 20 + std::min(bytes.size() - 20, json_bytes(bytes)));
            if (end == std::string::npos || end < 20) return;
            std::vector<Diagnostic> ignored;
            texts(
                parse_json(std::make_shared<const Source>(Source{name, bytes.substr(20, end - 19)}),
                           ignored),
                folder);
        } else if (extension == ".obj" || extension == ".mtl") {
            lines(read_whole_file(name), folder);
        }
    }

  private:
    static size_t json_bytes(const std::string& glb) {
        size_t size = 0;
        for (size_t i = 16; i-- > 12;) size = size << 8 | std::uint8_t(glb[i]);
        return size;
    }

    void texts(const Json& value, const fs::path& folder) {
        if (value.is(Json::Kind::text) && !value.text.empty() && value.text.size() < 4096)
            file(folder / decoded_uri(value.text));
        for (const Json& item : value.items) texts(item, folder);
        for (const JsonMember& member : value.members) texts(member.value, folder);
    }

    // "mtllib a.mtl", "map_Kd -s 1 1 1 a b.png": what follows each blank may be a name.
    void lines(const std::string& text, const fs::path& folder) {
        for (size_t at = 0; at < text.size();) {
            size_t end = text.find('\n', at);
            if (end == std::string::npos) end = text.size();
            std::string line = text.substr(at, end - at);
            at = end + 1;
            const size_t first = line.find_first_not_of(" \t");
            if (first == std::string::npos || line.size() > 4096) continue;
            const char c = line[first];
            if (c != 'm' && c != 'n' && c != 'b' && c != 'd' && c != 'r') continue;
            while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
            std::replace(line.begin(), line.end(), '\\', '/');
            for (size_t blank = line.find_first_of(" \t", first); blank != std::string::npos;
                 blank = line.find_first_of(" \t", blank + 1))
                if (blank + 1 < line.size()) file(folder / line.substr(blank + 1));
        }
    }

    std::set<std::string> seen_;
};

}  // namespace

std::vector<std::string> scene_files(const std::string& path) {
    Finder finder;
    try {
        finder.file(path);
    } catch (const Error&) {  // one that cannot be read is told when the scene is
    }
    return finder.found;
}

}  // namespace weft
