// robust-accumulate: each pixel the median of the means of `groups` interleaved parts of its locations
// (the one of median luminance), which a few far too bright ones cannot move. It darkens what is truly so.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "image/image.h"
#include "light-field/color_space_bytes.h"
#include "light-field/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct RobustAccumulate {
    int groups = 5;

    static void declare(Ports<RobustAccumulate>& node) {
        node.about("a picture from the radiance of its locations: medians of means, against outliers")
            .in<Colors>("colors", "radiance of each location")
            .in<Locations>("locations", "not looked at; so that it fits in accumulate's place", Need::optional)
            .out<Image>("image", "R G B; 0 where a pixel has no location")
            .param("groups", &RobustAccumulate::groups, {.min = 1, .max = 64, .about = "means of which the median is taken"});
    }

    static constexpr size_t values = 4;  // r g b count
    struct Scratch {
        std::vector<float> sums;              // pixels x groups x values
        std::vector<std::uint32_t> taken;     // locations so far, of each pixel
        std::vector<std::pair<float, size_t>> order;
        const std::string* color_space = nullptr;
        std::string loaded_space;
    };
    struct Result {
        Image image;
        std::atomic<const std::string*> color_space = nullptr;
    };

    void open(const Inputs&, const Extent& extent, Result& result) const { result.image = Image(extent.width, extent.height, 3); }
    void begin(const Inputs& in, Scratch& scratch) const {
        const size_t pixels = size_t(in.tile().width()) * size_t(in.tile().height());
        scratch.sums.assign(pixels * size_t(groups) * values, 0);
        scratch.taken.assign(pixels, 0);
    }
    void batch(const Inputs& in, Scratch& scratch) const {
        const Colors& colors = in.get<Colors>("colors");
        const Tile& tile = in.tile();
        const auto across = std::uint32_t(in.extent().width);
        scratch.color_space = colors.color_space;
        for (size_t l = 0; l < colors.size(); ++l) {
            const std::uint32_t px = colors.pixels[l] % across, py = colors.pixels[l] / across;
            const size_t local = size_t(py - std::uint32_t(tile.y0)) * size_t(tile.width()) + (px - std::uint32_t(tile.x0));
            const size_t group = scratch.taken[local]++ % size_t(groups);
            if (!colors.valid[l]) continue;
            float* to = &scratch.sums[(local * size_t(groups) + group) * values];
            for (size_t k = 0; k < 3; ++k) to[k] += colors.rgba[4 * l + k];
            to[3] += 1;
        }
    }
    void end(const Inputs& in, Scratch& scratch, Result& result) const {
        const Tile& tile = in.tile();
        const float* of = scratch.sums.data();
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x, of += size_t(groups) * values) {
                scratch.order.clear();
                for (size_t g = 0; g < size_t(groups); ++g) {
                    const float* sum = of + g * values;
                    if (sum[3] > 0) scratch.order.emplace_back((0.2126f * sum[0] + 0.7152f * sum[1] + 0.0722f * sum[2]) / sum[3], g);
                }
                if (scratch.order.empty()) continue;
                std::sort(scratch.order.begin(), scratch.order.end());
                const float* sum = of + scratch.order[scratch.order.size() / 2].second * values;
                for (int k = 0; k < 3; ++k) result.image.at(x, y)[k] = sum[k] / sum[3];
            }
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
    void close(const Inputs&, Result& result, Outputs& out, Context&) const {
        if (const std::string* space = result.color_space) result.image.color_space = *space;
        out.set("image", std::move(result.image));
    }
};

WEFT_NODE(RobustAccumulate, "robust-accumulate", 1)

}  // namespace
}  // namespace weft
