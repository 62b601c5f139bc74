// GltfFile: a glTF 2.0 document through tinygltf, with everything that it returns checked when it
// is asked for. Pictures stay encoded; only buffers are read.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "render/affine.h"

namespace weft {

// A uri without its %XX.
std::string decoded_uri(const std::string& uri);

class GltfFile {
  public:
    // Throws Error: not glTF, another version, extensions that cannot be left out, damage.
    GltfFile(const std::string& bytes, const std::string& path);

    const tinygltf::Model& model() const { return model_; }
    const std::string& path() const { return path_; }
    // Extensions that it uses and can be read without, as it is then.
    std::vector<std::string> unread_extensions() const;

    // Throws Error "FILE: ELEMENT: why".
    [[noreturn]] void fail(const std::string& element, const std::string& why) const;
    // `index` if it is one of `count`, else Error.
    size_t index(int index, size_t count, const std::string& element, const char* what) const;

    // An accessor's elements, `components` numbers each (0: whatever it has), normalized integers
    // as [0, 1] or [-1, 1]; all finite.
    std::vector<float> numbers(int accessor, int components, const std::string& element) const;
    std::vector<Vec3> vectors(int accessor, const std::string& element) const;
    std::vector<std::uint32_t> indices(int accessor, const std::string& element) const;

    // All of a buffer view.
    std::string bytes(int buffer_view, const std::string& element) const;

  private:
    struct View {
        const unsigned char* data = nullptr;  // null: zeros
        size_t count = 0, stride = 0;
        int type = 0, components = 0;
        bool normalized = false;
    };
    View view(int accessor, const std::string& element) const;
    const unsigned char* span(int buffer_view, size_t offset, size_t count, size_t stride,
                              size_t size, const std::string& element) const;

    std::string path_;
    tinygltf::Model model_;
};

}  // namespace weft
