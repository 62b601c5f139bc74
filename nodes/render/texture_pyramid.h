// TexturePyramid: a picture at all its sizes, each half the one before, in tiles of 64 x 64 pixels,
// RGBA, half, colour not premultiplied. The tiles lie in a file without a name in $TMPDIR (or
// /tmp), so that memory holds only what a cache keeps of them.
//   levels   0 is the picture; sizes round down, the last is 1 x 1; each pixel the mean of those
//            under it, colour weighted by alpha
//   memory   while it is made: 11 bytes a pixel; then nothing
// Threads: read() from any.
#pragma once
#include <Imath/half.h>

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace weft {

using TexturePixel = std::array<Imath::half, 4>;

class TexturePyramid {
  public:
    static constexpr int tile = 64;
    static constexpr size_t tile_bytes = size_t(tile) * tile * sizeof(TexturePixel);

    // `row(y, pixels)` fills row y; asked from 0 to height - 1, once each. `name`: for errors.
    TexturePyramid(const std::string& name, int width, int height,
                   const std::function<void(int y, TexturePixel* pixels)>& row);
    ~TexturePyramid();
    TexturePyramid(const TexturePyramid&) = delete;
    TexturePyramid& operator=(const TexturePyramid&) = delete;

    int levels() const { return int(levels_.size()); }
    int width(int level) const { return levels_[size_t(level)].width; }
    int height(int level) const { return levels_[size_t(level)].height; }
    // Tile (column, row) of a level; pixels past the picture's edge are 0. False: the file is gone.
    bool read(int level, int column, int row, void* pixels) const;

  private:
    struct Level {
        int width, height;
        size_t first_tile;  // in the file
    };
    void write(const std::vector<TexturePixel>& pixels, const Level& level,
               const std::string& name) const;
    std::vector<Level> levels_;
    int file_ = -1;
};

}  // namespace weft
