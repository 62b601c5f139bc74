// output-locations: where to reconstruct. All locations of a slice share one (u, v, t), and each pixel
// has its own (x, y) in it; so a stage can carry the samples to that (u, v, t) once for all of them.
// Source: Lehtinen et al. 2011, Sec. 3.1.  Departure: (u, v, t) are common to all pixels (points.h has
// the set), not one of 64 patterns a pixel; `sets` gives back some of that variety, and `spacing` saves
// what a scene in focus does not need.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "image/image.h"
#include "light-field/mean_blur.h"
#include "light-field/points.h"
#include "light-field/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

enum class Choice { sampled, fixed };
enum class Position { spread, center };

struct OutputLocations {
    int per_pixel = 128, per_slice = 1, per_light_point = 1, sets = 1;
    float spacing = 0;
    std::uint64_t seed = 1;
    Choice lens = Choice::sampled, time = Choice::sampled;
    Position position = Position::spread;
    float u = 0, v = 0, t = 0.5f;

    static void declare(Ports<OutputLocations>& node) {
        node.about("points (x, y, u, v, t) to reconstruct, slice by slice of one common (u, v, t)")
            .in<Hierarchy>("hierarchy", "gives the picture's size, lens and shutter",
                           Need::optional)
            .in<Samples>("samples", "gives them where there is no hierarchy", Need::optional)
            .in<Image>("shadow-paths", "how far shadows move that are looked for at the locations' times: counts for `spacing`", Need::optional)
            .out<Locations>("locations", "those of one tile, one slice a batch")
            .param("per-pixel", &OutputLocations::per_pixel, {.min = 1, .max = 1 << 20, .about = "locations a pixel"})
            .param("per-slice", &OutputLocations::per_slice,
                   {.min = 1, .max = 64, .about = "locations of a pixel that have one (u, v, t): faster, fewer points on the lens"})
            .param("spacing", &OutputLocations::spacing,
                   {.unit = "px", .min = 0, .max = 64,
                    .about = "more of a pixel's locations have one (u, v, t) where what is seen is then still shown at places no farther apart than "
                             "this, by the mean square of its blur: faster in focus, same picture up to noise; 0: nowhere"})
            .param("per-light-point", &OutputLocations::per_light_point,
                   {.min = 1, .max = 64,
                    .about = "of a pixel's locations that have one (u, v, t), as many look at a light from one of its points, too, and those that see "
                             "one surface ask for its shadow once: faster, fewer points of the light"})
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

    // Blocks of pixels, aligned to the picture so that nothing depends on tiles, each share slices as
    // far as their blur allows: of a pixel's locations per-slice times 2^level have one (u, v, t).
    static constexpr int block = light_field::location_block, levels = 7;
    // As many points of the light one (u, v, t) keeps at least: with fewer, lens and light together would be sampled by few where much is blurred.
    static constexpr size_t least_light_points = 16;

    struct Scratch {
        std::vector<light_field::LensPoint> points[levels];  // slice by slice, set by set
        std::vector<std::uint32_t> scramble_x, scramble_y;   // of the tile's pixels
        std::vector<int> level;                              // of the tile's blocks, row by row
        std::vector<std::uint32_t> groups;
        Tile of;
        bool filled = false;
    };

    Extent extent(const Inputs& in) const {
        if (const Hierarchy* h = in.find<Hierarchy>("hierarchy")) return {h->width, h->height};
        if (const Samples* s = in.find<Samples>("samples")) return {s->width, s->height};
        throw Error("the picture's size is not known; link 'hierarchy' or 'samples'");
    }

    size_t each(int level) const { return size_t(per_slice) << level; }
    size_t slices(int level) const { return (size_t(per_pixel) + each(level) - 1) / each(level); }
    // Of a pixel's locations that have one (u, v, t), how many are in a batch, and how many batches these are.
    size_t parts(int level) const { return each(level) / together(level); }
    size_t together(int level) const { return std::gcd(std::max<size_t>(each(level) / least_light_points, 1), size_t(per_light_point)); }

    const std::vector<light_field::LensPoint>& points_of(int level, const Inputs& in, Scratch& scratch) const {
        std::vector<light_field::LensPoint>& points = scratch.points[level];
        if (!points.empty()) return points;
        Lens shape;
        ShutterCurve shutter;
        if (const Hierarchy* h = in.find<Hierarchy>("hierarchy")) {
            shape = h->lens, shutter = h->shutter;
        } else {
            const Samples& samples = in.get<Samples>("samples");
            shape = samples.lens.value_or(Lens{}), shutter = shutter_of(samples.meta);
        }
        for (size_t i = 0; i < slices(level); ++i)
            for (int set = 0; set < sets; ++set) {
                light_field::LensPoint p =
                    light_field::lens_point(seed + 0x9e37u * std::uint64_t(set), std::uint32_t(i), std::uint32_t(slices(level)), shape);
                p.t = shutter.time(p.t);
                if (lens == Choice::fixed) p.u = u, p.v = v;
                if (time == Choice::fixed) p.t = t;
                points.push_back(p);
            }
        return points;
    }

    // The highest level whose slices, spread evenly over lens and shutter, show what is seen in a block, as a rule, at
    // places at most `spacing` apart (the few that are more out of focus err like noise): what the lens spreads over a disk, motion spreads along a line.
    // Of shadows that fall there the longest path counts: how much of them moves is not known.
    // Shadows move by `shadows`, or none do.
    int level_of(const Hierarchy& h, const Image* shadows, int x, int y, Scratch& scratch) const {
        const auto blur = light_field::mean_blur(h, x, y, std::min(x + block, h.width), std::min(y + block, h.height), scratch.groups);
        const double disk = lens == Choice::sampled ? 1 + double(blur.lens / spacing) : 1,
                     path = time == Choice::sampled ? double(std::max(blur.path, shadows ? *shadows->at(x / block, y / block) : 0) / spacing) : 0;
        int level = 0;
        while (level + 1 < levels && each(level) < size_t(per_pixel) && double(slices(level + 1)) >= disk * (disk + path)) ++level;
        return level;
    }

    void begin_tile(const Inputs& in, Scratch& scratch) const {
        const Tile& tile = in.tile();
        const Hierarchy* h = spacing > 0 ? in.find<Hierarchy>("hierarchy") : nullptr;
        const Image* shadows = in.find<Image>("shadow-paths");
        using light_field::blocks_across;
        if (h && shadows && (shadows->width() != blocks_across(h->width) || shadows->height() != blocks_across(h->height) || shadows->channels() != 1))
            throw Error("'shadow-paths' is not of this picture; expected what node shadow-paths makes of its samples");
        scratch.scramble_x.clear();
        scratch.scramble_y.clear();
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x) {
                const std::uint64_t scramble = light_field::pixel_scramble(seed, x, y);
                scratch.scramble_x.push_back(std::uint32_t(scramble));
                scratch.scramble_y.push_back(std::uint32_t(scramble >> 32));
            }
        scratch.level.clear();
        for (int y = tile.y0 / block * block; y < tile.y1; y += block)
            for (int x = tile.x0 / block * block; x < tile.x1; x += block)
                scratch.level.push_back(h ? level_of(*h, shadows, x, y, scratch) : 0);
        scratch.of = tile;
        scratch.filled = true;
    }

    bool next(const Inputs& in, size_t index, Outputs& out, Scratch& scratch) const {
        const Tile& tile = in.tile();
        if (!scratch.filled || scratch.of.index != tile.index || index == 0) begin_tile(in, scratch);
        // Level by level, slice by slice, set by set, some by some of a pixel's locations: what shares (u, v, t) is neighbours.
        int level = 0;
        const auto& of_blocks = scratch.level;
        for (;; ++level) {
            if (level == levels) return false;
            if (std::find(of_blocks.begin(), of_blocks.end(), level) == of_blocks.end()) continue;
            const size_t batches = slices(level) * size_t(sets) * parts(level);
            if (index < batches) break;
            index -= batches;
        }
        const size_t point = index / parts(level), number = point / size_t(sets) * parts(level) + index % parts(level);
        const int set = int(point % size_t(sets));
        const light_field::LensPoint p = points_of(level, in, scratch)[point];
        Locations& at = out.get<Locations>("locations");
        at.shared = true;
        at.u.assign(1, p.u);
        at.v.assign(1, p.v);
        at.t.assign(1, p.t);
        at.x0 = tile.x0;
        at.y0 = tile.y0;
        at.x1 = tile.x1;
        at.y1 = tile.y1;
        at.number = number;
        at.together = 0;
        const size_t most = together(level) * size_t(tile.width()) * size_t(tile.height());
        at.x.resize(most);
        at.y.resize(most);
        at.own_pixels.resize(most);
        // The first locations of all batches, which ask for shadows, are themselves evenly spread; so are the second.
        const size_t batches = slices(level) * parts(level);
        size_t n = 0;
        for (size_t i = number; at.together < together(level) && i < size_t(per_pixel); i += batches, ++at.together)
            n = add_one_a_pixel(in, scratch, level, set, i, at, n);
        at.together = std::max<size_t>(at.together, 1);
        at.pixels = std::span(at.own_pixels).first(n);
        at.parents = {};
        return true;
    }

  private:
    // Location i of each of the tile's pixels that are of a level and a set, from place n of the batch on; returns the place after them.
    size_t add_one_a_pixel(const Inputs& in, const Scratch& scratch, int level, int set, size_t i, Locations& at, size_t n) const {
        const Tile& tile = in.tile();
        const auto& of_blocks = scratch.level;
        const auto pattern = light_field::pixel_pattern(std::uint32_t(i));
        const bool spread = position == Position::spread;
        const size_t wide = size_t(tile.width());
        const bool some = sets > 1 || std::count(of_blocks.begin(), of_blocks.end(), level) < std::ptrdiff_t(of_blocks.size());
        const int blocks_across = (tile.x1 + block - 1) / block - tile.x0 / block;
        size_t pixel = 0;
        for (int y = tile.y0; y < tile.y1; ++y, pixel += wide) {
            // A whole row, as vectors; then, where not all pixels are in this batch, those that are.
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
            size_t kept = some ? 0 : wide;
            const int* of_row = &of_blocks[size_t(y / block - tile.y0 / block) * size_t(blocks_across)];
            for (size_t k = 0; k < wide && some; ++k) {
                const int x = tile.x0 + int(k);
                if (of_row[x / block - tile.x0 / block] != level || (sets > 1 && (x + 3 * y) % sets != set)) continue;
                to_x[kept] = to_x[k];
                to_y[kept] = to_y[k];
                to_pixel[kept++] = to_pixel[k];
            }
            n += kept;
        }
        return n;
    }
};

WEFT_NODE(OutputLocations, "output-locations", 3)

}  // namespace
}  // namespace weft
