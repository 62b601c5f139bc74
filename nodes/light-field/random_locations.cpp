// random-locations: each location at an (u, v, t) of its own, independent of all others. Nothing is shared,
// so every stage works location by location: slow, free of structure, and a check on output-locations.
#include "light-field/points.h"
#include "light-field/streams.h"
#include "runtime/node.h"
#include "samples/random.h"

namespace weft {
namespace {

struct RandomLocations {
    int per_pixel = 128;
    std::uint64_t seed = 1;

    static void declare(Ports<RandomLocations>& node) {
        node.about("independent random points (x, y, u, v, t) to reconstruct, pixel by pixel")
            .in<Hierarchy>("hierarchy", "gives the picture's size and the lens")
            .out<Locations>("locations", "those of some pixels of a row a batch")
            .param("per-pixel", &RandomLocations::per_pixel, {.min = 1, .max = 1 << 20, .about = "locations a pixel"})
            .param("seed", &RandomLocations::seed, {.about = "of all random choices"});
    }

    Extent extent(const Inputs& in) const {
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        return {h.width, h.height};
    }

    // A batch is a row of the tile; of more than 64 locations a pixel, 64 of each at a time.
    bool next(const Inputs& in, size_t index, Outputs& out) const {
        constexpr int at_once = 64;
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        const Tile& tile = in.tile();
        const size_t rounds = size_t((per_pixel + at_once - 1) / at_once);
        const int y = tile.y0 + int(index / rounds), first = int(index % rounds) * at_once;
        if (y >= tile.y1) return false;
        Locations& at = out.get<Locations>("locations");
        for (auto* values : {&at.x, &at.y, &at.u, &at.v, &at.t}) values->clear();
        at.own_pixels.clear();
        at.shared = false;
        at.x0 = tile.x0;
        at.x1 = tile.x1;
        at.y0 = y;
        at.y1 = y + 1;
        at.number = index;
        for (int x = tile.x0; x < tile.x1; ++x)
            for (int i = first; i < std::min(first + at_once, per_pixel); ++i) {
                std::uint64_t key = mix(light_field::pixel_scramble(seed, x, y) + std::uint64_t(i));
                const auto number = [&] { return unit_float(std::uint32_t((key = mix(key)) >> 32)); };
                at.x.push_back(float(x) + number());
                at.y.push_back(float(y) + number());
                const float a = number(), b = number();
                const auto uv = light_field::on_lens(a, b, h.lens);
                at.u.push_back(uv[0]);
                at.v.push_back(uv[1]);
                at.t.push_back(h.shutter.time(number()));
                at.own_pixels.push_back(std::uint32_t(y) * std::uint32_t(h.width) + std::uint32_t(x));
            }
        at.pixels = at.own_pixels;
        at.parents = {};
        return true;
    }
};

WEFT_NODE(RandomLocations, "random-locations", 1)

}  // namespace
}  // namespace weft
