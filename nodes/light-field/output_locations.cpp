// output-locations: where to reconstruct. All locations of a slice share one (u, v, t), and each pixel
// has its own (x, y) in it; so a stage can carry the samples to that (u, v, t) once for all of them.
// Source: Lehtinen et al. 2011, Sec. 3.1.  Departure: (u, v, t) are common to all pixels (points.h has
// the set), not one of 64 patterns a pixel; `sets` gives back some of that variety.
#include <vector>

#include "light-field/points.h"
#include "light-field/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

enum class Choice { sampled, fixed };
enum class Position { spread, center };

struct OutputLocations {
    int per_pixel = 128, per_slice = 1, sets = 1;
    std::uint64_t seed = 1;
    Choice lens = Choice::sampled, time = Choice::sampled;
    Position position = Position::spread;
    float u = 0, v = 0, t = 0.5f;

    static void declare(Ports<OutputLocations>& node) {
        node.about("points (x, y, u, v, t) to reconstruct, slice by slice of one common (u, v, t)")
            .in<Hierarchy>("hierarchy", "gives the picture's size, lens and shutter",
                           Need::optional)
            .in<Samples>("samples", "gives them where there is no hierarchy", Need::optional)
            .out<Locations>("locations", "those of one tile, one slice a batch")
            .param("per-pixel", &OutputLocations::per_pixel, {.min = 1, .max = 1 << 20, .about = "locations a pixel"})
            .param("per-slice", &OutputLocations::per_slice,
                   {.min = 1, .max = 64, .about = "locations of a pixel that have one (u, v, t): faster, fewer points on the lens"})
            .param("sets", &OutputLocations::sets,
                   {.min = 1, .max = 16,
                    .about = "sets of (u, v, t) that neighbouring pixels take in turn: noise instead of dots in large highlights, slower"})
            .param("seed", &OutputLocations::seed, {.about = "of all random choices"})
            .choice("lens", &OutputLocations::lens, {"sampled", "fixed"}, {.about = "positions over the whole lens, or u, v"})
            .param("u", &OutputLocations::u, {.min = -1, .max = 1, .about = "lens position where it is fixed"})
            .param("v", &OutputLocations::v, {.min = -1, .max = 1, .about = "lens position where it is fixed"})
            .choice("time", &OutputLocations::time, {"sampled", "fixed"}, {.about = "times over the whole shutter, or t"})
            .param("t", &OutputLocations::t, {.min = 0, .max = 1, .about = "time where it is fixed"})
            .choice("position", &OutputLocations::position, {"spread", "center"}, {.about = "spread over the pixel, or at its centre"});
    }

    struct Scratch {
        std::vector<light_field::LensPoint> points;         // slice by slice, set by set
        std::vector<std::uint32_t> scramble_x, scramble_y;  // of the tile's pixels
        Tile of;
        bool filled = false;
    };

    Extent extent(const Inputs& in) const {
        if (const Hierarchy* h = in.find<Hierarchy>("hierarchy")) return {h->width, h->height};
        if (const Samples* s = in.find<Samples>("samples")) return {s->width, s->height};
        throw Error("the picture's size is not known; link 'hierarchy' or 'samples'");
    }

    size_t slices() const { return size_t((per_pixel + per_slice - 1) / per_slice); }

    void prepare(const Inputs& in, Scratch& scratch) const {
        if (!scratch.points.empty()) return;
        Lens shape;
        ShutterCurve shutter;
        if (const Hierarchy* h = in.find<Hierarchy>("hierarchy")) {
            shape = h->lens, shutter = h->shutter;
        } else {
            const Samples& samples = in.get<Samples>("samples");
            shape = samples.lens.value_or(Lens{}), shutter = shutter_of(samples.meta);
        }
        for (size_t i = 0; i < slices(); ++i)
            for (int set = 0; set < sets; ++set) {
                light_field::LensPoint p =
                    light_field::lens_point(seed + 0x9e37u * std::uint64_t(set), std::uint32_t(i), std::uint32_t(slices()), shape);
                p.t = shutter.time(p.t);
                if (lens == Choice::fixed) p.u = u, p.v = v;
                if (time == Choice::fixed) p.t = t;
                scratch.points.push_back(p);
            }
    }

    bool next(const Inputs& in, size_t index, Outputs& out, Scratch& scratch) const {
        const Tile& tile = in.tile();
        // Slice by slice, set by set, location by location of a pixel: what shares (u, v, t) is neighbours.
        const size_t each = size_t(per_slice), point = index / each, i = point / size_t(sets) * each + index % each;
        const int set = int(point % size_t(sets));
        prepare(in, scratch);
        if (point >= scratch.points.size()) return false;
        if (!scratch.filled || scratch.of.index != tile.index || index == 0) {
            scratch.scramble_x.clear();
            scratch.scramble_y.clear();
            for (int y = tile.y0; y < tile.y1; ++y)
                for (int x = tile.x0; x < tile.x1; ++x) {
                    const std::uint64_t scramble = light_field::pixel_scramble(seed, x, y);
                    scratch.scramble_x.push_back(std::uint32_t(scramble));
                    scratch.scramble_y.push_back(std::uint32_t(scramble >> 32));
                }
            scratch.of = tile;
            scratch.filled = true;
        }
        Locations& at = out.get<Locations>("locations");
        const light_field::LensPoint p = scratch.points[point];
        at.shared = true;
        at.u.assign(1, p.u);
        at.v.assign(1, p.v);
        at.t.assign(1, p.t);
        at.x0 = tile.x0;
        at.y0 = tile.y0;
        at.x1 = tile.x1;
        at.y1 = tile.y1;
        at.slice = point;
        const size_t most = size_t(tile.width()) * size_t(tile.height());
        at.x.resize(most);
        at.y.resize(most);
        at.own_pixels.resize(most);
        const auto pattern = light_field::pixel_pattern(std::uint32_t(i));
        const bool spread = position == Position::spread;
        const size_t wide = size_t(tile.width());
        size_t n = 0, pixel = 0;
        for (int y = tile.y0; y < tile.y1 && i < size_t(per_pixel); ++y, pixel += wide) {
            // A whole row, as vectors; then, of several sets, what is in this one.
            float *to_x = &at.x[n], *to_y = &at.y[n];
            std::uint32_t* to_pixel = &at.own_pixels[n];
            const std::uint32_t *scramble_x = &scratch.scramble_x[pixel],
                                *scramble_y = &scratch.scramble_y[pixel];
            const std::uint32_t first =
                std::uint32_t(y) * std::uint32_t(in.extent().width) + std::uint32_t(tile.x0);
            for (size_t k = 0; k < wide; ++k) {
                to_x[k] = float(tile.x0 + int(k)) +
                          (spread ? unit_float(pattern[0] ^ scramble_x[k]) : 0.5f);
                to_y[k] = float(y) + (spread ? unit_float(pattern[1] ^ scramble_y[k]) : 0.5f);
                to_pixel[k] = first + std::uint32_t(k);
            }
            size_t kept = sets > 1 ? 0 : wide;
            for (size_t k = 0; k < wide && sets > 1; ++k) {
                if ((tile.x0 + int(k) + 3 * y) % sets != set) continue;
                to_x[kept] = to_x[k];
                to_y[kept] = to_y[k];
                to_pixel[kept++] = to_pixel[k];
            }
            n += kept;
        }
        at.pixels = std::span(at.own_pixels).first(n);
        at.parents = {};
        return true;
    }
};

WEFT_NODE(OutputLocations, "output-locations", 1)

}  // namespace
}  // namespace weft
