// Textures through OpenImageIO, in the module weft_oiio. Each file is read once, when it is first
// asked for: converted to the scene's colours, filtered to all its sizes (texture_pyramid.h), and
// handed to the cache that stands under OpenImageIO's TextureSystem as a tiled picture, so that the
// cache bounds the memory and averages are made of light, not of sRGB codes. A lookup then takes
// one texel, chosen at random among those that a trilinear filter would weigh: its mean is the
// filter's, and its cost a quarter of one. (Stochastic texture filtering: Fajardo et al. 2023.)
// Departure from TextureSystem's own lookups: level and texel are chosen here, so that they depend
// on the arguments alone, and it is faster: a batch keeps the tiles it has at hand. Million lookups
// a CPU second on one thread (bench_texture_lookups, and TextureSystem's batches of 16 by
// bench_texture_system, in one sitting): a picture's pixels in rows 21, TextureSystem trilinear
// 6.4, its nearest texel of one level 12.5; scattered over 2048^2 texels 2.5, 1.8 and 2.2; with a
// footprint of 64 texels 19, 6.8 and 12.
#include "render/oiio_textures.h"

#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>

#include "image/oiio_open.h"
#include "render/bump_map.h"
#include "render/texture_pyramid.h"

namespace weft {
namespace {

using Wrap = TextureMap::Wrap;
constexpr int tile = TexturePyramid::tile;

std::string bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file || std::filesystem::is_directory(path))
        throw Error(fmt::format("{}: the texture cannot be read: no such file", path));
    return {std::istreambuf_iterator<char>(file), {}};
}

// Pyramids by the name under which the cache asks for them.
struct Shelf {
    std::mutex lock;
    std::map<std::string, const TexturePyramid*, std::less<>> pyramids;
};
Shelf& shelf() {
    static Shelf all;
    return all;
}

// A pyramid, as OpenImageIO wants to read a picture.
class PyramidInput final : public OIIO::ImageInput {
  public:
    const char* format_name() const override { return "weft-pyramid"; }
    int supports(OIIO::string_view) const override { return 0; }
    bool open(const std::string& name, OIIO::ImageSpec& spec) override {
        Shelf& all = shelf();
        const std::lock_guard guard(all.lock);
        const auto found = all.pyramids.find(name);
        if (found == all.pyramids.end()) return false;
        pyramid_ = found->second;
        seek_subimage(0, 0);
        spec = m_spec;
        return true;
    }
    bool close() override { return true; }
    int current_miplevel() const override { return level_; }
    bool seek_subimage(int subimage, int level) override {
        if (subimage != 0 || level < 0 || level >= pyramid_->levels()) return false;
        level_ = level;
        m_spec = OIIO::ImageSpec(pyramid_->width(level), pyramid_->height(level), 4,
                                 OIIO::TypeDesc::HALF);
        m_spec.tile_width = m_spec.tile_height = tile;
        m_spec.tile_depth = 1;
        return true;
    }
    bool read_native_scanline(int, int, int, int, void*) override { return false; }
    bool read_native_tile(int, int level, int x, int y, int, void* data) override {
        return pyramid_->read(level, x / tile, y / tile, data);
    }

  private:
    const TexturePyramid* pyramid_ = nullptr;
    int level_ = 0;
};

OIIO::ImageInput* make_pyramid_input() {
    return new PyramidInput;
}

int wrapped(int i, int size, Wrap wrap) {
    switch (wrap) {
        case Wrap::clamp:
            return std::clamp(i, 0, size - 1);
        case Wrap::mirror: {
            const int k = (i % (2 * size) + 2 * size) % (2 * size);
            return k < size ? k : 2 * size - 1 - k;
        }
        case Wrap::repeat:
            break;
    }
    const int k = i % size;
    return k < 0 ? k + size : k;
}

// True with probability p by random number r, which is even in [0, 1) again afterwards.
bool chosen(float p, float& r) {
    const bool yes = r < p;
    r = yes ? r / p : (r - p) / (1 - p);
    if (!(r < 1)) r = 0x1.fffffep-1f;
    return yes;
}

// The texel that coordinate u falls on at a level of `size` texels, or its neighbour.
int texel(float u, int size, Wrap wrap, float& r) {
    // Coordinates far out are brought near first, so that they fit an int.
    if (!std::isfinite(u)) u = 0;
    if (std::fabs(u) > 1e4f) u = wrap == Wrap::clamp ? std::copysign(2.0f, u) : std::fmod(u, 2.0f);
    const float s = u * float(size) - 0.5f, low = std::floor(s), part = s - low;
    return wrapped(int(low) + (part > 0 && chosen(part, r) ? 1 : 0), size, wrap);
}

// What the cache keeps for a thread, lent to a batch at a time. The cache's own, one a thread,
// outlives it: the next cache at its address finds it again, with a tile that is gone.
class ThreadInfos {
  public:
    explicit ThreadInfos(OIIO::ImageCache& cache) : cache_(cache) {}
    ~ThreadInfos() {
        for (OIIO::ImageCache::Perthread* info : idle_) cache_.destroy_thread_info(info);
    }
    ThreadInfos(const ThreadInfos&) = delete;
    ThreadInfos& operator=(const ThreadInfos&) = delete;

    OIIO::ImageCache::Perthread* take() {
        const std::lock_guard guard(lock_);
        if (idle_.empty()) return cache_.create_thread_info();
        OIIO::ImageCache::Perthread* info = idle_.back();
        idle_.pop_back();
        return info;
    }
    void give_back(OIIO::ImageCache::Perthread* info) {
        const std::lock_guard guard(lock_);
        idle_.push_back(info);
    }

  private:
    OIIO::ImageCache& cache_;
    std::mutex lock_;
    std::vector<OIIO::ImageCache::Perthread*> idle_;
};

// The tiles that a batch has at hand.
class Held {
  public:
    Held(OIIO::ImageCache& cache, ThreadInfos& infos, OIIO::ImageCache::ImageHandle* file)
        : cache_(cache), infos_(infos), file_(file), thread_(infos.take()) {}
    ~Held() {
        for (Entry& e : entries_)
            if (e.tile) cache_.release_tile(e.tile);
        infos_.give_back(thread_);
    }
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;

    // Null: the cache could not read it.
    const TexturePixel* pixel(int level, int x, int y) {
        const int column = x / tile, row = y / tile;
        Entry& e = entries_[size_t(level * 5 + column + 3 * row) % count];
        if (!e.tile || e.level != level || e.column != column || e.row != row) {
            if (e.tile) cache_.release_tile(e.tile);
            e = {cache_.get_tile(file_, thread_, 0, level, column * tile, row * tile, 0, 0, 4),
                 nullptr, level, column, row};
            if (!e.tile) return nullptr;
            OIIO::TypeDesc format;
            e.pixels = static_cast<const TexturePixel*>(cache_.tile_pixels(e.tile, format));
            if (!e.pixels || format != OIIO::TypeDesc::HALF) return nullptr;
        }
        return e.pixels + size_t(y - row * tile) * tile + size_t(x - column * tile);
    }

  private:
    static constexpr size_t count = 32;
    struct Entry {
        OIIO::ImageCache::Tile* tile = nullptr;
        const TexturePixel* pixels = nullptr;
        int level = 0, column = 0, row = 0;
    };
    OIIO::ImageCache& cache_;
    ThreadInfos& infos_;
    OIIO::ImageCache::ImageHandle* file_;
    OIIO::ImageCache::Perthread* thread_;
    Entry entries_[count];
};

class CachedTextures final : public Textures {
  public:
    CachedTextures(const Scene& scene, const std::vector<bool>& used, const TextureOptions& options)
        : options_(options),
          cache_(OIIO::ImageCache::create(false)),
          infos_(std::make_unique<ThreadInfos>(*cache_)),
          files_(used.size()) {
        cache_->attribute("max_memory_MB", float(double(options.cache_bytes) / (1 << 20)));
        cache_->attribute("max_open_files", 1 << 20);  // ours cost nothing
        try {
            for (size_t i = 0; i < used.size(); ++i)
                if (used[i]) {
                    files_[i] = std::make_unique<File>();
                    files_[i]->source = scene.textures[i];
                    check(*files_[i]);
                }
        } catch (...) {
            close();
            throw;
        }
    }

    ~CachedTextures() override {
        close();
        Shelf& all = shelf();
        const std::lock_guard guard(all.lock);
        for (const auto& file : files_)
            if (file) all.pyramids.erase(file->name);
    }

    bool has_alpha(int index) const override { return used(index).has_alpha; }

    void lookup(int index, Wrap wrap_u, Wrap wrap_v, std::span<const Vec2> uv,
                std::span<const float> width, std::span<const float> random,
                std::span<float> rgba) const override {
        File* file = &used(index);
        std::call_once(file->once, [&] { load(*file); });
        const TexturePyramid& pyramid = *file->pyramid;
        const float across = float(std::max(pyramid.width(0), pyramid.height(0)));
        Held held(*cache_, *infos_, file->handle);
        for (size_t i = 0; i < uv.size(); ++i) {
            float r = random[i];
            int level = 0;
            // Footprints of one texel or less are seen at the finest level; NaN too.
            if (width[i] * across > 1) {
                const float fine = std::log2(width[i] * across);
                const float limit = float(pyramid.levels() - 1);
                if (fine >= limit)
                    level = pyramid.levels() - 1;
                else {
                    level = int(fine);
                    const float part = fine - float(level);
                    if (part > 0 && chosen(part, r)) ++level;
                }
            }
            const int x = texel(uv[i].x, pyramid.width(level), wrap_u, r);
            const int y = texel(uv[i].y, pyramid.height(level), wrap_v, r);
            const TexturePixel* pixel = held.pixel(level, x, y);
            if (!pixel)
                throw Error(fmt::format("{}: its tiles cannot be read: {}", file->source.path,
                                        told(cache_->geterror())));
            for (size_t c = 0; c < 4; ++c) rgba[4 * i + c] = float((*pixel)[c]);
        }
    }

  private:
    struct File {
        TextureFile source;
        bool has_alpha = false;
        std::once_flag once;
        std::string name;
        std::unique_ptr<TexturePyramid> pyramid;
        OIIO::ImageCache::ImageHandle* handle = nullptr;
    };

    File& used(int index) const {
        if (index < 0 || size_t(index) >= files_.size() || !files_[size_t(index)])
            throw Error(fmt::format("texture {} is used by no material of this scene", index));
        return *files_[size_t(index)];
    }

    // Its header, so that a missing or foreign file is told before anything is rendered.
    static void check(File& file) {
        Opened opened;
        std::string held;
        file.has_alpha = alpha_channel(header(file.source, held, opened)) >= 0;
    }

    static int alpha_channel(const OIIO::ImageSpec& spec) {
        if (spec.alpha_channel >= 0 && spec.alpha_channel < spec.nchannels)
            return spec.alpha_channel;
        return spec.nchannels == 2 ? 1 : spec.nchannels == 4 ? 3 : -1;
    }

    static OIIO::ImageSpec header(const TextureFile& source, std::string& held, Opened& opened) {
        if (!source.bytes) held = bytes_of(source.path);
        const std::string& bytes = source.bytes ? *source.bytes : held;
        open(bytes, source.path, opened, true);
        const OIIO::ImageSpec spec = opened.input->spec();
        const double size = 4.0 * spec.width * double(spec.height) * spec.nchannels;
        if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || spec.width > 1 << 16 ||
            spec.height > 1 << 16 || size > 1e5 * double(bytes.size()) + 1e6)
            throw Error(fmt::format("{}: not a texture: a header of {} x {} pixels and {} channels",
                                    source.path, spec.width, spec.height, spec.nchannels));
        return spec;
    }

    void load(File& file) const {
        const TextureFile& source = file.source;
        Opened opened;
        std::string held;
        const OIIO::ImageSpec spec = header(source, held, opened);
        const int channels = spec.nchannels, width = spec.width;
        const int alpha = alpha_channel(spec);
        const bool colored = channels >= 3, whole = spec.format.basetype < OIIO::TypeDesc::HALF;
        const bool divide =
            alpha >= 0 && !whole && !spec.get_int_attribute("oiio:UnassociatedAlpha");
        // An 8 or 16 bit colour is sRGB whatever a JPEG says; a float picture says what it is.
        const std::string space =
            whole ? "sRGB - Texture"
                  : from_oiio(spec.get_string_attribute("oiio:ColorSpace"), false);
        constexpr int strip = 64;
        std::vector<float> values(size_t(width) * size_t(channels) * strip);
        std::vector<float> rgb(size_t(width) * 3);
        int begin = 0, end = 0;
        // Reads row y; `rgb` then holds its colours, what it returns all its channels.
        const auto read = [&](int y) {
            if (y >= end) {
                begin = y, end = std::min(y + strip, spec.height);
                // Pictures in tiles are read in rows of tiles.
                if (spec.tile_width > 0) {
                    if (y == 0) {
                        values.resize(size_t(width) * size_t(channels) * size_t(spec.height));
                        begin = 0, end = spec.height;
                        if (!opened.input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT,
                                                      values.data()))
                            damaged(source, opened);
                    }
                } else if (!opened.input->read_scanlines(0, 0, spec.y + begin, spec.y + end, 0, 0,
                                                         channels, OIIO::TypeDesc::FLOAT,
                                                         values.data())) {
                    damaged(source, opened);
                }
            }
            const float* in = values.data() + size_t(y - begin) * size_t(width) * size_t(channels);
            for (int x = 0; x < width; ++x) {
                const float* p = in + size_t(x) * size_t(channels);
                const float a = divide && p[alpha] > 0 ? 1 / p[alpha] : 1.0f;
                for (int c = 0; c < 3; ++c) rgb[size_t(3 * x + c)] = p[colored ? c : 0] * a;
            }
            if (source.color) options_.to_scene(space, rgb.data(), size_t(width));
            return in;
        };
        std::vector<float> bumps;
        if (source.bump != 0) {
            bumps.reserve(rgb.size() * size_t(spec.height));
            for (int y = 0; y < spec.height; ++y) {
                read(y);
                bumps.insert(bumps.end(), rgb.begin(), rgb.end());
            }
            bumps_to_normals(bumps, width, spec.height, source.bump);
        }
        const auto row = [&](int y, TexturePixel* pixels) {
            const float* in = bumps.empty() ? read(y) : nullptr;
            const float* from = in ? rgb.data() : &bumps[rgb.size() * size_t(y)];
            for (int x = 0; x < width; ++x) {
                for (size_t c = 0; c < 3; ++c) {
                    const float v = from[3 * size_t(x) + c];
                    pixels[x][c] =
                        Imath::half(std::isfinite(v) ? std::clamp(v, -65504.0f, 65504.0f) : 0);
                }
                const float a =
                    in && alpha >= 0 ? in[size_t(x) * size_t(channels) + size_t(alpha)] : 1.0f;
                pixels[x][3] = Imath::half(a >= 0 ? std::min(a, 1.0f) : 0.0f);
            }
        };
        file.pyramid = std::make_unique<TexturePyramid>(source.path, width, spec.height, row);
        static std::atomic<std::uint64_t> next{0};
        file.name = fmt::format("weft-texture-{}", next++);
        {
            Shelf& all = shelf();
            const std::lock_guard guard(all.lock);
            all.pyramids[file.name] = file.pyramid.get();
        }
        const OIIO::ustring name(file.name);
        cache_->add_file(name, make_pyramid_input);
        file.handle = cache_->get_image_handle(name);
        if (!file.handle || !cache_->good(file.handle))
            throw Error(fmt::format("{}: the texture cache does not take it: {}", source.path,
                                    told(cache_->geterror())));
    }

    [[noreturn]] static void damaged(const TextureFile& source, const Opened& opened) {
        throw Error(fmt::format("{}: not a whole picture: {}", source.path,
                                told(opened.input->geterror())));
    }

    void close() {
        infos_.reset();
        OIIO::ImageCache::destroy(cache_, true);
    }

    TextureOptions options_;
    OIIO::ImageCache* cache_;
    std::unique_ptr<ThreadInfos> infos_;
    std::vector<std::unique_ptr<File>> files_;
};

}  // namespace
}  // namespace weft

weft::Textures* weft_open_textures(const weft::Scene& scene, const std::vector<bool>& used,
                                   const weft::TextureOptions& options) {
    OIIO::attribute("threads", 1);
    return new weft::CachedTextures(scene, used, options);
}
