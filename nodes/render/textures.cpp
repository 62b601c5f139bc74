#include "render/textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "color/color_config.h"
#include "graph/error.h"
#include "image/other_formats.h"
#include "render/oiio_textures.h"

namespace weft {
namespace {

class NoTextures final : public Textures {
  public:
    void lookup(int file, TextureMap::Wrap, TextureMap::Wrap, std::span<const Vec2>,
                std::span<const float>, std::span<const float>, std::span<float>) const override {
        throw Error(fmt::format("texture {} is used by no material of this scene", file));
    }
    bool has_alpha(int) const override { return false; }
};

std::vector<bool> textures_used(const Scene& scene) {
    std::vector<bool> used(scene.textures.size());
    for (const Material& m : scene.materials)
        for (const TextureMap* map : m.maps())
            if (map->used()) used.at(size_t(map->file)) = true;
    return used;
}

}  // namespace

std::unique_ptr<Textures> open_textures(const Scene& scene, size_t cache_bytes) {
    const std::vector<bool> used = textures_used(scene);
    const auto first = std::find(used.begin(), used.end(), true);
    if (first == used.end()) return std::make_unique<NoTextures>();
    const TextureFile& file = scene.textures[size_t(first - used.begin())];
    TextureOptions options;
    options.cache_bytes = cache_bytes;
    struct Transforms {
        std::mutex lock;
        std::map<std::string, ColorTransform> by_space;
    };
    options.to_scene = [to = scene.color_space, known = std::make_shared<Transforms>()](
                           const std::string& space, float* rgb, size_t pixels) {
        if (space == to) return;
        ColorTransform transform;
        {
            const std::lock_guard guard(known->lock);
            auto found = known->by_space.find(space);
            if (found == known->by_space.end())
                found =
                    known->by_space.emplace(space, ColorConfig::open("")->convert(space, to)).first;
            transform = found->second;
        }
        for (size_t i = 0; i < 3 * pixels; ++i)  // an infinite value would become NaN
            rgb[i] = std::isfinite(rgb[i]) ? std::clamp(rgb[i], -65504.0f, 65504.0f) : 0.0f;
        transform.apply(rgb, pixels);
    };
    const auto open = reinterpret_cast<decltype(&weft_open_textures)>(
        oiio_entry(file.path, "weft_open_textures"));
    return std::unique_ptr<Textures>(open(scene, used, options));
}

}  // namespace weft
