// filter-tiles: a picture from rendered samples, tile by tile: pixel-filter without a sample
// buffer. A wider filter sums what a pixel's samples give to each pixel around it first, in their
// order, then adds these sums row by row: so the result does not depend on tiles.
#include <fmt/format.h>

#include <atomic>
#include <cmath>

#include "filters/pixel_filter_parameters.h"
#include "image/image.h"
#include "render/rendered_tiles.h"
#include "runtime/node.h"

namespace weft::render {
namespace {

struct FilterTiles : FilterChoice {
    bool alpha = false;

    static void declare(Ports<FilterTiles>& node) {
        node.about("a picture from rendered samples by a pixel filter, without holding the samples")
            .in<RenderedTiles>("samples", "of render-tiles")
            .out<Image>("image", "R G B, and A if asked for; 0 where no sample reaches")
            .out<Image>("variance",
                        "R G B: of the mean of a pixel's own samples, estimated from their spread");
        declare_filter(node);
        node.param("alpha", &FilterTiles::alpha,
                   {.about = "adds coverage as A, where the samples have it"});
    }

    static constexpr size_t values = 5;  // r g b a weight

    // Of a pixel's own samples, whatever the filter.
    struct Own {
        double color[3] = {}, square[3] = {}, count = 0;
    };
    struct Scratch {
        std::vector<double> sums;  // of each of the tile's pixels, for each pixel around it
        std::vector<Own> own;      // of each of the tile's pixels
        std::vector<double> wx, wy;
        std::string color_space;
        const RenderedHead* head = nullptr;
    };
    struct Result {
        Extent extent;
        std::vector<double> sums;  // pixels x patch x values
        std::vector<Own> own;
        std::mutex mutex;
        std::string color_space;
        const RenderedHead* head = nullptr;
    };

    PixelFilter shape() const { return make_filter(*this); }
    int around() const {
        const PixelFilter f = shape();
        return is_pixel_box(f) ? 0 : std::max(0, int(std::ceil(radius_of(f) + 0.5f)) - 1);
    }
    size_t patch() const { return size_t(2 * around() + 1) * size_t(2 * around() + 1); }

    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        const double pixels = double(s.width) * double(s.height);
        return {{{"image", {s.width, s.height, 3 + alpha, 0, (12.0 + 4 * alpha) * pixels}}},
                double(8 * values * patch() + sizeof(Own)) * pixels,
                0};
    }

    void open(const Inputs&, const Extent& extent, Result& result) const {
        result.extent = extent;
        result.sums.assign(size_t(extent.width) * size_t(extent.height) * patch() * values, 0);
        result.own.assign(size_t(extent.width) * size_t(extent.height), {});
    }
    void begin(const Inputs& in, Scratch& scratch) const {
        scratch.own.assign(size_t(in.tile().width()) * size_t(in.tile().height()), {});
        scratch.sums.assign(
            size_t(in.tile().width()) * size_t(in.tile().height()) * patch() * values, 0);
    }
    void batch(const Inputs& in, Scratch& scratch) const {
        const RenderedTiles& from = in.get<RenderedTiles>("samples");
        const Tile& tile = in.tile();
        const auto across = std::uint32_t(in.extent().width);
        scratch.color_space = from.head->samples.color_space;
        scratch.head = from.head;
        const bool has_alpha = from.head->channels.has(ChannelId::alpha);
        const PixelFilter f = shape();
        const bool box = is_pixel_box(f);
        const int r = around(), side = 2 * r + 1;
        const size_t each = patch() * values;
        scratch.wx.assign(size_t(side), 1), scratch.wy.assign(size_t(side), 1);
        for (size_t i = 0; i < from.size(); ++i) {
            const int px = int(from.pixels[i] % across), py = int(from.pixels[i] / across);
            const size_t local = size_t(py - tile.y0) * size_t(tile.width()) + size_t(px - tile.x0);
            const float* rgb = from.batch.at(ChannelId::rgb, i);
            const float sample[4] = {rgb[0], rgb[1], rgb[2],
                                     has_alpha ? *from.batch.at(ChannelId::alpha, i) : 1};
            if (!box) {
                const float* xy = from.batch.at(ChannelId::xy, i);
                for (int k = 0; k < side; ++k) {
                    scratch.wx[size_t(k)] = double(evaluate(f, xy[0] - (float(px + k - r) + 0.5f)));
                    scratch.wy[size_t(k)] = double(evaluate(f, xy[1] - (float(py + k - r) + 0.5f)));
                }
            }
            Own& own = scratch.own[local];
            for (int k = 0; k < 3; ++k) {
                own.color[k] += double(rgb[k]);
                own.square[k] += double(rgb[k]) * double(rgb[k]);
            }
            ++own.count;
            double* to = &scratch.sums[local * each];
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x, to += values) {
                    const double weight = scratch.wx[size_t(x)] * scratch.wy[size_t(y)];
                    for (int k = 0; k < 4; ++k) to[k] += weight * double(sample[k]);
                    to[4] += weight;
                }
        }
    }
    void end(const Inputs& in, Scratch& scratch, Result& result) const {
        const Tile& tile = in.tile();
        const size_t each = patch() * values, row = size_t(tile.width()) * each;
        for (int y = tile.y0; y < tile.y1; ++y)
            std::copy_n(
                &scratch.sums[size_t(y - tile.y0) * row], row,
                &result.sums[(size_t(y) * size_t(result.extent.width) + size_t(tile.x0)) * each]);
        const size_t across = size_t(tile.width());
        for (int y = tile.y0; y < tile.y1; ++y)
            std::copy_n(&scratch.own[size_t(y - tile.y0) * across], across,
                        &result.own[size_t(y) * size_t(result.extent.width) + size_t(tile.x0)]);
        const std::lock_guard lock(result.mutex);
        if (scratch.head) result.head = scratch.head;
        if (!scratch.color_space.empty()) result.color_space = scratch.color_space;
    }
    void close(const Inputs&, Result& result, Outputs& out, Context& ctx) const {
        const int w = result.extent.width, h = result.extent.height, r = around(), side = 2 * r + 1;
        Image image(w, h, 3 + alpha);
        image.color_space = result.color_space;
        std::atomic<size_t> empty = 0;
        const size_t each = patch() * values;
        ctx.parallel_rows(h, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < w; ++x) {
                    double sum[values] = {};
                    for (int j = std::max(y - r, 0); j <= std::min(y + r, h - 1); ++j)
                        for (int i = std::max(x - r, 0); i <= std::min(x + r, w - 1); ++i) {
                            const size_t place =
                                size_t(y - j + r) * size_t(side) + size_t(x - i + r);
                            const double* from =
                                &result.sums[(size_t(j) * size_t(w) + size_t(i)) * each +
                                             place * values];
                            for (size_t k = 0; k < values; ++k) sum[k] += from[k];
                        }
                    if (!(sum[4] > 0)) {
                        ++empty;
                        continue;
                    }
                    for (int k = 0; k < 3 + alpha; ++k) image.at(x, y)[k] = float(sum[k] / sum[4]);
                }
        });
        if (result.head) result.head->warn(ctx);
        if (empty > 0)
            ctx.warn(fmt::format("{} of {} pixels have no sample within the filter; they are 0",
                                 size_t(empty), size_t(w) * size_t(h)));
        if (out.wanted("image")) out.set("image", std::move(image));
        if (out.wanted("variance")) out.set("variance", variance_of(result));
    }
    static Image variance_of(const Result& result) {
        Image variance(result.extent.width, result.extent.height, 3);
        variance.color_space = "Raw";
        for (size_t i = 0; i < result.own.size(); ++i) {
            const Own& own = result.own[i];
            if (own.count < 2) continue;
            for (size_t k = 0; k < 3; ++k) {
                const double mean = own.color[k] / own.count;
                variance.pixels()[3 * i + k] =
                    float(std::max(0.0, own.square[k] / own.count - mean * mean) / (own.count - 1));
            }
        }
        return variance;
    }

    void save(const Inputs&, const Scratch& scratch, ByteWriter& to) const {
        to.put_text(scratch.color_space);
        to.put_all(scratch.sums);
        to.put_all(scratch.own);
    }
    void load(const Inputs&, ByteReader& from, Scratch& scratch) const {
        scratch.color_space = from.take_text();
        from.fill(scratch.sums);
        from.fill(scratch.own);
    }
};

WEFT_NODE(FilterTiles, "filter-tiles", 1);

}  // namespace
}  // namespace weft::render
