// scanline-locations: a slice of the light field: one scanline, row after row of the picture at another
// lens position or time. What is in focus, or stands still, is a vertical line; slopes are depths, speeds.
#include "light-field/points.h"
#include "light-field/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

enum class Axis { lens, time };

struct ScanlineLocations {
    Axis axis = Axis::lens;
    float scanline = 0.5f, u = 0, v = 0, t = 0.5f;
    int rows = 128, per_pixel = 4;
    std::uint64_t seed = 1;

    static void declare(Ports<ScanlineLocations>& node) {
        node.about("one scanline, seen from lens positions or at times that change from row to row: (x, u) and (x, t) slices")
            .in<Hierarchy>("hierarchy", "gives the picture's width and the lens")
            .out<Locations>("locations", "those of one row of a tile a batch")
            .choice("axis", &ScanlineLocations::axis, {"lens", "time"}, {.about = "what changes down the rows: u from -1 to 1, or t from 0 to 1"})
            .param("scanline", &ScanlineLocations::scanline, {.min = 0, .max = 1, .about = "its place in the picture, 0 the top, 1 the bottom"})
            .param("rows", &ScanlineLocations::rows, {.unit = "px", .min = 1, .max = 1 << 16, .about = "height of the slice"})
            .param("u", &ScanlineLocations::u, {.min = -1, .max = 1, .about = "lens position where it does not change"})
            .param("v", &ScanlineLocations::v, {.min = -1, .max = 1, .about = "lens position"})
            .param("t", &ScanlineLocations::t, {.min = 0, .max = 1, .about = "time where it does not change"})
            .param("per-pixel", &ScanlineLocations::per_pixel, {.min = 1, .max = 4096, .about = "locations a pixel, spread in x"})
            .param("seed", &ScanlineLocations::seed, {.about = "of all random choices"});
    }

    Extent extent(const Inputs& in) const {
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        return {h.width, h.height > 0 ? rows : 0};
    }

    bool next(const Inputs& in, size_t index, Outputs& out) const {
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        const Tile& tile = in.tile();
        const int row = tile.y0 + int(index);
        if (row >= tile.y1) return false;
        const float along = (float(row) + 0.5f) / float(rows);
        const int line = std::min(int(scanline * float(h.height)), h.height - 1);
        Locations& at = out.get<Locations>("locations");
        at.shared = true;
        at.u.assign(1, axis == Axis::lens ? 2 * along - 1 : u);
        at.v.assign(1, v);
        at.t.assign(1, axis == Axis::time ? along : t);
        at.x.clear();
        at.y.clear();
        at.own_pixels.clear();
        at.x0 = tile.x0;
        at.x1 = tile.x1;
        at.y0 = line;
        at.y1 = line + 1;
        at.number = std::uint64_t(row);
        for (int x = tile.x0; x < tile.x1; ++x) {
            const auto scramble = std::uint32_t(light_field::pixel_scramble(seed, x, row));
            for (int i = 0; i < per_pixel; ++i) {
                at.x.push_back(float(x) + unit_float(light_field::pixel_pattern(std::uint32_t(i))[0] ^ scramble));
                at.y.push_back(float(line) + 0.5f);
                at.own_pixels.push_back(std::uint32_t(row) * std::uint32_t(h.width) + std::uint32_t(x));
            }
        }
        at.pixels = at.own_pixels;
        at.parents = {};
        return true;
    }
};

WEFT_NODE(ScanlineLocations, "scanline-locations", 1)

}  // namespace
}  // namespace weft
