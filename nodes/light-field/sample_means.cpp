// sample-means: the mean of each pixel's own samples, tile by tile beside the locations that are
// reconstructed there: noisy, but right on average, which is what `preserve-energy` asks for.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <mutex>

#include "image/image.h"
#include "light-field/streams.h"
#include "runtime/node.h"
#include "samples/samples.h"

namespace weft {
namespace {

// The part of lens and shutter that was met.
struct Spread {
    std::array<float, 3> least, most;  // of u, v, t

    Spread() {
        least.fill(std::numeric_limits<float>::max());
        most.fill(std::numeric_limits<float>::lowest());
    }
    void add(size_t axis, std::span<const float> values) {
        for (const float value : values) {
            least[axis] = std::min(least[axis], value);
            most[axis] = std::max(most[axis], value);
        }
    }
    void add(const Spread& other) {
        for (size_t axis = 0; axis < 3; ++axis) {
            least[axis] = std::min(least[axis], other.least[axis]);
            most[axis] = std::max(most[axis], other.most[axis]);
        }
    }
    bool one_lens_position() const { return !(most[0] > least[0]) && !(most[1] > least[1]); }
    bool one_time() const { return !(most[2] > least[2]); }
};

struct SampleMeans {
    static void declare(Ports<SampleMeans>& node) {
        node.about(
                "means of each pixel's own samples, made where locations are: what a "
                "reconstruction's energy is held to")
            .in<Locations>(
                "locations",
                "what is reconstructed: its tiles, and whether it covers lens and shutter")
            .in<Samples>("samples", "rgb, as rendered; any samples a pixel")
            .out<Image>("image",
                        "R G B and samples, how many there are; all 0 where the locations are at "
                        "one lens position or time and the samples are not");
    }
    static constexpr int channels = 4;  // r g b samples

    struct Scratch {
        std::vector<float> means;  // of the tile's pixels
        Spread of_locations;
        bool has_lens = false, has_motion = false;
        std::string color_space;
    };
    struct Result {
        std::mutex mutex;
        Image image;
        Spread of_locations;
        bool has_lens = false, has_motion = false;
    };

    Cost cost(const Shapes& in) const {
        const Shape s = in["locations"];
        return {{{"image",
                  {s.width, s.height, channels, 0,
                   4.0 * channels * double(s.width) * double(s.height)}}},
                0,
                0};
    }
    void open(const Inputs& in, const Extent& extent, Result& result) const {
        result.image = Image(extent.width, extent.height, {"R", "G", "B", "samples"});
        const Samples* samples = in.find<Samples>("samples");
        if (!samples) return;  // a merge
        samples->require("sample-means", {"rgb"});
        if (samples->domain != "camera" || samples->width != extent.width ||
            samples->height != extent.height)
            throw Error(fmt::format(
                "'sample-means' got samples of {} x {} in domain '{}' for locations of {} x {}; "
                "link the samples that these are reconstructed from",
                samples->width, samples->height, samples->domain, extent.width, extent.height));
    }
    void begin(const Inputs& in, Scratch& scratch) const {
        const Tile& tile = in.tile();
        scratch.means.assign(size_t(tile.width()) * size_t(tile.height()) * channels, 0);
        scratch.of_locations = {};
        const Samples* samples = in.find<Samples>("samples");
        if (!samples) return;
        scratch.has_lens = samples->has_lens();
        scratch.has_motion = samples->has_motion();
        scratch.color_space = samples->color_space;
        float* to = scratch.means.data();
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x, to += channels)
                add_pixel(*samples, size_t(y) * size_t(samples->width) + size_t(x), to);
    }
    static void add_pixel(const Samples& samples, size_t pixel, float* to) {
        const std::span<const float> rgb = samples.rgb();
        const auto [begin, end] = samples.of_pixel(pixel);
        for (size_t i = begin; i < end; ++i)
            for (size_t c = 0; c < 3; ++c) to[c] += rgb[3 * i + c];
        for (size_t c = 0; c < 3 && end > begin; ++c) to[c] /= float(end - begin);
        to[3] = float(end - begin);
    }
    void batch(const Inputs& in, Scratch& scratch) const {
        const Locations& at = in.get<Locations>("locations");
        scratch.of_locations.add(0, at.u);
        scratch.of_locations.add(1, at.v);
        scratch.of_locations.add(2, at.t);
    }
    void end(const Inputs& in, Scratch& scratch, Result& result) const {
        const Tile& tile = in.tile();
        const size_t row = size_t(tile.width()) * channels;
        for (int y = tile.y0; y < tile.y1; ++y)
            std::copy_n(&scratch.means[size_t(y - tile.y0) * row], row,
                        result.image.at(tile.x0, y));
        const std::lock_guard lock(result.mutex);
        result.of_locations.add(scratch.of_locations);
        result.has_lens |= scratch.has_lens;
        result.has_motion |= scratch.has_motion;
        result.image.color_space = scratch.color_space;
    }
    void save(const Inputs&, const Scratch& scratch, ByteWriter& to) const {
        to.put_all(scratch.means);
        to.put(scratch.of_locations);
        to.put(scratch.has_lens);
        to.put(scratch.has_motion);
        to.put_text(scratch.color_space);
    }
    void load(const Inputs&, ByteReader& from, Scratch& scratch) const {
        from.fill(scratch.means);
        scratch.of_locations = from.take<Spread>();
        scratch.has_lens = from.take<bool>();
        scratch.has_motion = from.take<bool>();
        scratch.color_space = from.take_text();
    }
    void close(const Inputs&, Result& result, Outputs& out, Context& ctx) const {
        const bool other_lens = result.has_lens && result.of_locations.one_lens_position();
        const bool other_time = result.has_motion && result.of_locations.one_time();
        Image& image = result.image;
        if (other_lens || other_time) {
            ctx.warn(
                fmt::format("locations are all at one {}, samples at many: the picture is not the "
                            "mean of the samples, which are left out; bypass what goes by them",
                            other_lens ? "place on the lens" : "time"));
            for (int y = 0; y < image.height(); ++y)
                std::fill_n(image.at(0, y), size_t(image.width()) * channels, 0.0f);
        }
        out.set("image", std::move(image));
    }
};

WEFT_NODE(SampleMeans, "sample-means", 1)

}  // namespace
}  // namespace weft
