// collect-samples: filtered colours put into the samples they are of; all other channels are shared
// with them.
#include <algorithm>

#include "rpf/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct CollectSamples {
    static void declare(Ports<CollectSamples>& node) {
        node.about(
                "the samples, with filtered colours in place of theirs; samples that nobody "
                "filtered keep their own")
            .in<SampleColors>("colors", "filtered colours")
            .in<Samples>("samples", "those whose rgb is replaced")
            .out<Samples>("samples", "all channels as they were, but rgb");
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"samples", {s.width, s.height, 0, s.records, s.bytes + 12 * double(s.records)}}},
                0,
                0};
    }

    struct Scratch {
        std::vector<std::uint32_t> sample;
        std::vector<float> rgb;  // 3 each
    };
    struct Result {
        std::vector<float> rgb;
    };
    void open(const Inputs& in, const Extent&, Result& result) const {
        const auto rgb = in.get<Samples>("samples").rgb();
        result.rgb.assign(rgb.begin(), rgb.end());
    }
    void begin(const Inputs&, Scratch& scratch) const {
        scratch.sample.clear();
        scratch.rgb.clear();
    }
    // Of a block that lies across tiles each takes its own pixels.
    void batch(const Inputs& in, Scratch& scratch) const {
        const SampleColors& colors = in.get<SampleColors>("colors");
        const Tile& tile = in.tile();
        for (size_t p = 0; p < colors.own_pixels.size(); ++p) {
            const int x = int(colors.own_pixels[p] % std::uint32_t(in.extent().width)),
                      y = int(colors.own_pixels[p] / std::uint32_t(in.extent().width));
            if (x < tile.x0 || x >= tile.x1 || y < tile.y0 || y >= tile.y1) continue;
            const auto begin = std::ptrdiff_t(colors.own_offset[p]),
                       end = std::ptrdiff_t(colors.own_offset[p + 1]);
            scratch.sample.insert(scratch.sample.end(), colors.sample.begin() + begin,
                                  colors.sample.begin() + end);
            scratch.rgb.insert(scratch.rgb.end(), colors.rgb.begin() + 3 * begin,
                               colors.rgb.begin() + 3 * end);
        }
    }
    void end(const Inputs&, Scratch& scratch, Result& result) const {
        for (size_t i = 0; i < scratch.sample.size(); ++i)
            std::copy_n(&scratch.rgb[3 * i], 3, &result.rgb[3 * size_t(scratch.sample[i])]);
    }
    void close(const Inputs& in, Result& result, Outputs& out, Context&) const {
        Samples samples = in.get<Samples>("samples");
        samples.add("rgb", 3, std::move(result.rgb));
        out.set("samples", std::move(samples));
    }
};

WEFT_NODE(CollectSamples, "collect-samples", 1)

}  // namespace
}  // namespace weft
