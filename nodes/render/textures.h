// Textures: colours out of a scene's texture files, loaded piece by piece into a cache of bounded
// size. OpenImageIO does the work, in a module that is loaded by the first scene that has a
// texture.
#pragma once
#include <memory>
#include <span>

#include "render/scene.h"

namespace weft {

// A surface's texture coordinates in a map's own: offset + rotate(scale * uv, rotation), turned
// counter-clockwise as seen with u to the right and v down. (The listing in the extension's text
// turns the other way; its words and its example are meant.)
inline Vec2 place(const TextureMap& map, Vec2 uv) {
    const Vec2 s{map.scale.x * uv.x, map.scale.y * uv.y};
    if (map.rotation == 0) return {map.offset.x + s.x, map.offset.y + s.y};
    const float c = std::cos(map.rotation), r = std::sin(map.rotation);
    return {map.offset.x + c * s.x + r * s.y, map.offset.y - r * s.x + c * s.y};
}

class Textures {
  public:
    virtual ~Textures() = default;

    // Looks `uv` up, a batch at once. A texture's v runs down from its top row, as in glTF.
    //   uv      N, in the map's own coordinates (TextureMap's offset, scale, rotation done by the
    //   caller: see place()) width   N footprints in uv units: no finer level than this asks for is
    //   read; 0: the finest random  N numbers in [0, 1) that choose between two levels and between
    //   neighbouring texels rgba    N x 4: colour files in the scene's colour space, others as they
    //   are; alpha 1 where a file has none
    // Pure: the same arguments give the same bits, whatever was asked before. Throws Error (a file
    // is damaged). Threads: any.
    virtual void lookup(int file, TextureMap::Wrap wrap_u, TextureMap::Wrap wrap_v,
                        std::span<const Vec2> uv, std::span<const float> width,
                        std::span<const float> random, std::span<float> rgba) const = 0;

    // Whether the file has an alpha channel. A material's alpha_map takes the first channel of a
    // file of numbers (TextureFile::color false) that has none.
    virtual bool has_alpha(int file) const = 0;
};

// Opens every file that the scene's materials use; throws Error naming the file that is missing or
// no picture. A scene without textures costs nothing.
std::unique_ptr<Textures> open_textures(const Scene& scene, size_t cache_bytes = size_t(256) << 20);

}  // namespace weft
