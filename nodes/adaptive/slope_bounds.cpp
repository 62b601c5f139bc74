// slope-bounds: how fast what a pixel sees moves over the film, by time and by lens position, at
// least and at most. A pixel must know of every path that crosses it while the shutter is open, not
// of samples alone that landed in it: a fast thing that no sample caught there would leave a hole
// in its trail. So each sample's whole path is noted, in tiles of a few pixels.
// Source: Egan et al. 2009, Sec. 4.
#include <fmt/format.h>

#include <atomic>
#include <bit>

#include "adaptive/sample_paths.h"
#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

constexpr int tile = 4;

// The least or greatest of many floats, whatever order they come in.
class Extreme {
  public:
    void take(float value) {
        const std::uint32_t bits = ordered(value);
        std::uint32_t now = bits_.load(std::memory_order_relaxed);
        while (bits > now && !bits_.compare_exchange_weak(now, bits, std::memory_order_relaxed)) {
        }
    }
    float value() const {
        const std::uint32_t b = bits_.load();
        return std::bit_cast<float>(b & 0x80000000u ? b ^ 0x80000000u : ~b);
    }

  private:
    static std::uint32_t ordered(float value) {
        const auto b = std::bit_cast<std::uint32_t>(value);
        return b & 0x80000000u ? ~b : b | 0x80000000u;
    }
    std::atomic<std::uint32_t> bits_{0};
};

// What crosses a tile. Least values are noted as greatest of their opposites.
struct TileBounds {
    std::atomic<std::uint64_t> fastest{0};  // squared speed, then the sample: later ones are lower
    std::atomic<std::uint32_t> count{0};
    Extreme lo, hi, across_lo, across_hi, lens_lo, lens_hi;
};

struct SlopeBounds {
    enum class Effect { motion, lens, both };
    Effect effect = Effect::both;
    float window = 1;
    int min_samples = 2;

    static void declare(Ports<SlopeBounds>& node) {
        node.about(
                "bounds of the slopes of all paths that cross a pixel while the shutter is open, "
                "from anywhere on the lens")
            .in<Samples>("samples", "xy, z (t and motion; uv and a lens)")
            .out<Image>(
                "slopes",
                "s-lo, s-hi: -speed along n, px a shutter; n.x, n.y: way of the fastest; "
                "across-lo, across-hi: across n; lens-lo, lens-hi: -circle of confusion, px; "
                "count: paths, 0: too few")
            .choice("effect", &SlopeBounds::effect, {"motion", "lens", "both"},
                    {.about = "what to bound; the picture has channels for that alone"})
            .param("window", &SlopeBounds::window,
                   {.unit = "px",
                    .min = 0,
                    .max = 64,
                    .about = "paths this near to a pixel's tile count as crossing it"})
            .param("min-samples", &SlopeBounds::min_samples,
                   {.unit = "samples",
                    .min = 1,
                    .max = 1e6,
                    .about = "paths that a tile of 4 x 4 pixels needs for bounds"});
    }
    std::vector<std::string> channels() const {
        std::vector<std::string> names;
        if (effect != Effect::lens)
            names = {"s-lo", "s-hi", "n.x", "n.y", "across-lo", "across-hi"};
        if (effect != Effect::motion) names.insert(names.end(), {"lens-lo", "lens-hi"});
        names.push_back("count");
        return names;
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"slopes", image_shape(s.width, s.height, std::int64_t(channels().size()))}},
                double(s.width) * double(s.height) / (tile * tile) * sizeof(TileBounds),
                400.0 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        samples.require("slope-bounds", {"xy", "z"});
        if (samples.domain != "camera")
            ctx.fail(
                fmt::format("needs a camera's samples, these are of domain '{}'; for a "
                            "light's visibility there is occluder-bounds",
                            samples.domain));
        const SamplePaths paths(samples);
        const int across = (samples.width + tile - 1) / tile,
                  down = (samples.height + tile - 1) / tile;
        std::vector<TileBounds> tiles(size_t(across) * size_t(down));
        const auto each_tile = [&](const auto& work) {
            ctx.parallel(samples.size(), 4096, [&](size_t begin, size_t end) {
                for (size_t i = begin; i < end; ++i) {
                    const auto v = paths.velocity(i);
                    if (!std::isfinite(v[0] + v[1])) continue;
                    paths.cross(i, window, effect != Effect::lens, effect != Effect::motion, tile,
                                across, down, [&](size_t at) { work(i, v, tiles[at]); });
                }
            });
        };
        if (effect != Effect::lens)
            each_tile([](size_t i, const std::array<float, 2>& v, TileBounds& to) {
                const auto speed = std::bit_cast<std::uint32_t>(v[0] * v[0] + v[1] * v[1]);
                const std::uint64_t key = std::uint64_t(speed) << 32 | (~std::uint32_t(i));
                std::uint64_t now = to.fastest.load(std::memory_order_relaxed);
                while (key > now &&
                       !to.fastest.compare_exchange_weak(now, key, std::memory_order_relaxed)) {
                }
            });
        each_tile([&](size_t i, const std::array<float, 2>& v, TileBounds& to) {
            to.count.fetch_add(1, std::memory_order_relaxed);
            const float coc = paths.coc(i);
            to.lens_lo.take(coc), to.lens_hi.take(-coc);
            const auto n = direction(paths, to);
            const float along = n[0] * v[0] + n[1] * v[1], aside = n[0] * v[1] - n[1] * v[0];
            to.lo.take(along), to.hi.take(-along);
            to.across_lo.take(aside), to.across_hi.take(-aside);
        });

        Image slopes(samples.width, samples.height, channels());
        slopes.color_space = "Raw";
        ctx.parallel_rows(samples.height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < samples.width; ++x) {
                    const TileBounds& of =
                        tiles[size_t(y / tile) * size_t(across) + size_t(x / tile)];
                    float* to = slopes.at(x, y);
                    const auto count = of.count.load();
                    if (count < std::uint32_t(min_samples)) continue;
                    if (effect != Effect::lens) {
                        const auto n = direction(paths, of);
                        for (const float value : {-of.lo.value(), of.hi.value(), n[0], n[1],
                                                  -of.across_lo.value(), of.across_hi.value()})
                            *to++ = value;
                    }
                    if (effect != Effect::motion)
                        *to++ = -of.lens_lo.value(), *to++ = of.lens_hi.value();
                    *to = float(count);
                }
        });
        out.set("slopes", std::move(slopes));
    }

  private:
    // Where the fastest path goes; to the right where nothing moves.
    static std::array<float, 2> direction(const SamplePaths& paths, const TileBounds& of) {
        const std::uint64_t key = of.fastest.load(std::memory_order_relaxed);
        if (key >> 32 == 0) return {1, 0};
        const auto v = paths.velocity(size_t(~std::uint32_t(key)));
        const float speed = std::hypot(v[0], v[1]);
        return {v[0] / speed, v[1] / speed};
    }
};

WEFT_NODE(SlopeBounds, "slope-bounds", 1)

}  // namespace
}  // namespace weft
