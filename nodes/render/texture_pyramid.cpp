#include "render/texture_pyramid.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "graph/error.h"

namespace weft {
namespace {

std::string temporary_folder() {
    const char* set = std::getenv("TMPDIR");
    return set && *set ? set : "/tmp";
}

[[noreturn]] void no_room(const std::string& name) {
    throw Error(fmt::format("{}: no room for its tiles in {} ({}); set TMPDIR to another folder",
                            name, temporary_folder(), std::strerror(errno)));
}

int nameless_file(const std::string& name) {
    std::string path = temporary_folder() + "/weft-texture-XXXXXX";
    const int file = mkostemp(path.data(), O_CLOEXEC);
    if (file < 0) no_room(name);
    unlink(path.c_str());
    return file;
}

int tiles(int pixels) {
    return (pixels + TexturePyramid::tile - 1) / TexturePyramid::tile;
}

// Which pixels of `from` lie under pixel i of `to`, and how much of each: at most 3.
struct Under {
    int first = 0, count = 0;
    std::array<float, 4> weight{};
};
Under under(int i, int from, int to) {
    const double low = double(i) * from / to, high = double(i + 1) * from / to;
    Under u;
    u.first = int(low);
    for (int k = u.first; k < high && k < from && u.count < 4; ++k)
        u.weight[size_t(u.count++)] =
            float(std::min<double>(high, k + 1) - std::max<double>(low, k));
    return u;
}

std::vector<TexturePixel> halved(const std::vector<TexturePixel>& pixels, int width, int height,
                                 int to_width, int to_height) {
    std::vector<TexturePixel> small(size_t(to_width) * size_t(to_height));
    std::vector<Under> columns;
    for (int x = 0; x < to_width; ++x) columns.push_back(under(x, width, to_width));
    for (int y = 0; y < to_height; ++y) {
        const Under rows = under(y, height, to_height);
        for (int x = 0; x < to_width; ++x) {
            const Under& across = columns[size_t(x)];
            float sum[3] = {}, plain[3] = {}, alpha = 0, total = 0;
            for (int j = 0; j < rows.count; ++j)
                for (int i = 0; i < across.count; ++i) {
                    const TexturePixel& p =
                        pixels[size_t(rows.first + j) * size_t(width) + size_t(across.first + i)];
                    const float w = rows.weight[size_t(j)] * across.weight[size_t(i)];
                    const float a = p[3];
                    for (size_t c = 0; c < 3; ++c)
                        sum[c] += w * a * float(p[c]), plain[c] += w * float(p[c]);
                    alpha += w * a, total += w;
                }
            TexturePixel& out = small[size_t(y) * size_t(to_width) + size_t(x)];
            for (size_t c = 0; c < 3; ++c)
                out[c] = Imath::half(alpha > 0 ? sum[c] / alpha : plain[c] / total);
            out[3] = Imath::half(alpha / total);
        }
    }
    return small;
}

}  // namespace

TexturePyramid::TexturePyramid(const std::string& name, int width, int height,
                               const std::function<void(int y, TexturePixel* pixels)>& row) {
    std::vector<TexturePixel> pixels(size_t(width) * size_t(height));
    for (int y = 0; y < height; ++y) row(y, pixels.data() + size_t(y) * size_t(width));
    file_ = nameless_file(name);
    try {
        for (size_t first = 0;;) {
            levels_.push_back({width, height, first});
            write(pixels, levels_.back(), name);
            first += size_t(tiles(width)) * size_t(tiles(height));
            if (width == 1 && height == 1) break;
            const int w = std::max(width / 2, 1), h = std::max(height / 2, 1);
            pixels = halved(pixels, width, height, w, h);
            width = w, height = h;
        }
    } catch (...) {
        close(file_);
        throw;
    }
}

TexturePyramid::~TexturePyramid() {
    close(file_);
}

void TexturePyramid::write(const std::vector<TexturePixel>& pixels, const Level& level,
                           const std::string& name) const {
    // A row of tiles at once.
    const int across = tiles(level.width);
    std::vector<TexturePixel> buffer(size_t(across) * tile * tile);
    for (int row = 0; row < tiles(level.height); ++row) {
        std::fill(buffer.begin(), buffer.end(), TexturePixel{});
        for (int y = 0; y < std::min<int>(tile, level.height - row * tile); ++y)
            for (int column = 0; column < across; ++column) {
                const int x = column * tile, count = std::min<int>(tile, level.width - x);
                const TexturePixel* from =
                    pixels.data() + size_t(row * tile + y) * size_t(level.width) + size_t(x);
                std::copy(from, from + count,
                          buffer.data() + (size_t(column) * tile + size_t(y)) * tile);
            }
        const char* bytes = reinterpret_cast<const char*>(buffer.data());
        size_t left = buffer.size() * sizeof(TexturePixel);
        auto at = off_t((level.first_tile + size_t(row) * size_t(across)) * tile_bytes);
        while (left > 0) {
            const ssize_t done = pwrite(file_, bytes, left, at);
            if (done < 0 && errno == EINTR) continue;
            if (done <= 0) no_room(name);
            bytes += done, left -= size_t(done), at += done;
        }
    }
}

bool TexturePyramid::read(int level, int column, int row, void* pixels) const {
    const Level& l = levels_[size_t(level)];
    const size_t index = l.first_tile + size_t(row) * size_t(tiles(l.width)) + size_t(column);
    auto* bytes = static_cast<char*>(pixels);
    size_t left = tile_bytes;
    auto at = off_t(index * tile_bytes);
    while (left > 0) {
        const ssize_t done = pread(file_, bytes, left, at);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) return false;
        bytes += done, left -= size_t(done), at += done;
    }
    return true;
}

}  // namespace weft
