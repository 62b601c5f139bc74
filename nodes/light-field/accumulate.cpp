// accumulate: a picture from the locations' radiance: each pixel the mean of its own, or the weighted mean
// of all around it under a pixel filter.
// A wider filter sums what a pixel's locations give to each pixel around it first, in the order they come,
// then adds these sums row by row: so the result does not depend on tiles.
#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cmath>

#include "filters/pixel_filter_parameters.h"
#include "image/image.h"
#include "light-field/color_space_bytes.h"
#include "light-field/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct Accumulate : FilterChoice {
    bool alpha = false;

    static void declare(Ports<Accumulate>& node) {
        node.about("a picture from the radiance of its locations")
            .in<Colors>("colors", "radiance of each location")
            .in<Locations>("locations", "where they lie; needed by filters other than the box of one pixel", Need::optional)
            .out<Image>("image", "R G B, and A if asked for; 0 where a pixel has no location");
        declare_filter(node);
        node.param("alpha", &Accumulate::alpha,
                   {.about = "keep A, the part covered by anything but background: for compositing. Without it the background is part of the picture"});
    }

    static constexpr size_t values = 5;  // r g b a weight

    struct Scratch {
        std::vector<float> sums;  // of each of the tile's pixels, for each pixel around it
        std::vector<float> wx, wy;
        const std::string* color_space = nullptr;
        std::string loaded_space;
    };
    struct Result {
        Extent extent;
        int around = 0;           // pixels to each side that a location counts for
        LargeArray<float> sums;  // pixels x (2 around + 1)^2 x values
        std::atomic<const std::string*> color_space = nullptr;
    };

    PixelFilter pixel_filter() const { return make_filter(*this); }
    // A location's own pixel centre is at most half a pixel away.
    int around() const {
        const PixelFilter f = pixel_filter();
        return is_pixel_box(f) ? 0 : std::max(0, int(std::ceil(radius_of(f) + 0.5f)) - 1);
    }
    static size_t patch(int around) { return size_t(2 * around + 1) * size_t(2 * around + 1); }

    Cost cost(const Shapes& in) const {
        const Shape s = in["colors"];
        const double pixels = double(s.width) * double(s.height);
        return {{{"image", {s.width, s.height, 4, 0, 16 * pixels}}}, 4 * values * pixels * double(patch(around())), 0};
    }

    void open(const Inputs&, const Extent& extent, Result& result) const {
        result.extent = extent;
        result.around = around();
        result.sums.assign(size_t(extent.width) * size_t(extent.height) * patch(result.around) * values, 0);
    }
    void begin(const Inputs& in, Scratch& scratch) const {
        scratch.sums.assign(size_t(in.tile().width()) * size_t(in.tile().height()) * patch(around()) * values, 0);
    }
    void batch(const Inputs& in, Scratch& scratch) const {
        const Colors& colors = in.get<Colors>("colors");
        const Tile& tile = in.tile();
        const auto across = std::uint32_t(in.extent().width), wide = std::uint32_t(tile.width());
        scratch.color_space = colors.color_space;
        const PixelFilter f = pixel_filter();
        const bool box = is_pixel_box(f);
        const Locations* at = in.find<Locations>("locations");
        if (!box && !at) throw Error("filters other than the box of one pixel need 'locations': link it, or set filter to box and width to 0");
        if (box) return add_to_own(colors, tile, across, scratch.sums);
        const int r = around(), side = 2 * r + 1;
        scratch.wx.resize(size_t(side));
        scratch.wy.resize(size_t(side));
        for (size_t l = 0; l < colors.size(); ++l) {
            const std::uint32_t px = colors.pixels[l] % across, py = colors.pixels[l] / across;
            const size_t local = size_t(py - std::uint32_t(tile.y0)) * wide + (px - std::uint32_t(tile.x0));
            const float* rgba = &colors.rgba[4 * l];
            if (!colors.valid[l]) continue;
            float* to = &scratch.sums[local * patch(r) * values];
            for (int i = 0; i < side; ++i) {
                scratch.wx[size_t(i)] = evaluate(f, at->x[l] - (float(int(px) + i - r) + 0.5f));
                scratch.wy[size_t(i)] = evaluate(f, at->y[l] - (float(int(py) + i - r) + 0.5f));
            }
            for (int j = 0; j < side; ++j)
                for (int i = 0; i < side; ++i, to += values) {
                    const float w = scratch.wx[size_t(i)] * scratch.wy[size_t(j)];
                    for (size_t k = 0; k < 4; ++k) to[k] += w * rgba[k];
                    to[4] += w;
                }
        }
    }

    // The box of one pixel: a location counts for its own only. Most come pixel after pixel.
    static void add_to_own(const Colors& colors, const Tile& tile, std::uint32_t across,
                           std::vector<float>& sums) {
        std::uint32_t next = 0;
        size_t local = size_t(-1);
        for (size_t l = 0; l < colors.size(); ++l) {
            const std::uint32_t pixel = colors.pixels[l];
            if (l > 0 && pixel == next) {
                ++local;
            } else {
                const std::uint32_t px = pixel % across, py = pixel / across;
                local = size_t(py - std::uint32_t(tile.y0)) * size_t(tile.width()) +
                        (px - std::uint32_t(tile.x0));
            }
            next = pixel + 1;
            if (!colors.valid[l]) continue;
            std::array<float, 4> rgba;
            std::copy_n(&colors.rgba[4 * l], 4, rgba.begin());
            float* to = &sums[local * values];
            for (size_t k = 0; k < 4; ++k) to[k] += rgba[k];
            to[4] += 1;
        }
    }

    void end(const Inputs& in, Scratch& scratch, Result& result) const {
        const Tile& tile = in.tile();
        const size_t each = patch(result.around) * values, row = size_t(tile.width()) * each;
        for (int y = tile.y0; y < tile.y1; ++y)
            std::copy_n(&scratch.sums[size_t(y - tile.y0) * row], row,
                        &result.sums[(size_t(y) * size_t(result.extent.width) + size_t(tile.x0)) * each]);
        if (scratch.color_space) result.color_space = scratch.color_space;
    }

    void save(const Inputs&, const Scratch& scratch, ByteWriter& to) const {
        to.put_all(scratch.sums);
        save_color_space(scratch.color_space, to);
    }
    void load(const Inputs&, ByteReader& from, Scratch& scratch) const {
        from.fill(scratch.sums);
        scratch.color_space = load_color_space(from, scratch.loaded_space);
    }

    void close(const Inputs&, Result& result, Outputs& out, Context& ctx) const {
        const int w = result.extent.width, h = result.extent.height, r = result.around, side = 2 * r + 1;
        Image image(w, h, 4);
        std::atomic<size_t> empty = 0;
        ctx.parallel_rows(h, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < w; ++x) {
                    double sum[values] = {};
                    for (int j = std::max(y - r, 0); j <= std::min(y + r, h - 1); ++j)
                        for (int i = std::max(x - r, 0); i <= std::min(x + r, w - 1); ++i) {
                            // What pixel (i, j) gives to the one at (x - i, y - j) from it.
                            const size_t place = size_t(y - j + r) * size_t(side) + size_t(x - i + r);
                            const float* from = &result.sums[((size_t(j) * size_t(w) + size_t(i)) * patch(r) + place) * values];
                            for (size_t k = 0; k < values; ++k) sum[k] += double(from[k]);
                        }
                    float* to = image.at(x, y);
                    if (!(sum[4] > 0)) {
                        ++empty;
                        continue;
                    }
                    for (size_t k = 0; k < 4; ++k) to[k] = float(sum[k] / sum[4]);
                }
        });
        if (empty > 0 && size_t(w) * size_t(h) > 0)
            ctx.warn(fmt::format("{} of {} pixels have no location with a colour and are black", size_t(empty), size_t(w) * size_t(h)));
        if (!alpha) {
            Image opaque(w, h, 3);
            for (int y = 0; y < h; ++y)
                for (int x = 0; x < w; ++x) std::copy_n(image.at(x, y), 3, opaque.at(x, y));
            image = std::move(opaque);
        }
        if (const std::string* space = result.color_space) image.color_space = *space;
        out.set("image", std::move(image));
    }
};

WEFT_NODE(Accumulate, "accumulate", 1)

}  // namespace
}  // namespace weft
