// The texture part of the module weft_oiio: what Weft asks of it, and what it asks back.
#pragma once
#include <cstddef>
#include <functional>
#include <string>

#include "render/textures.h"

namespace weft {

struct TextureOptions {
    size_t cache_bytes = size_t(256) << 20;
    // From a space that a file is in to the scene's: rgb in place.
    std::function<void(const std::string& space, float* rgb, size_t pixels)> to_scene;
};

}  // namespace weft

// `used[i]`: whether texture i is read at all. The caller owns what it gets.
extern "C" weft::Textures* weft_open_textures(const weft::Scene& scene,
                                              const std::vector<bool>& used,
                                              const weft::TextureOptions& options);
