// count-samples: how many samples each pixel has: where an adaptive renderer looked.
#include "image/image.h"
#include "runtime/node.h"
#include "samples/samples.h"

namespace weft {
namespace {

struct CountSamples {
    static void declare(Ports<CountSamples>& node) {
        node.about("samples of each pixel, over their mean")
            .in<Samples>("samples", "with as many a pixel as there are")
            .out<Image>("image", "R G B: 1 where a pixel has as many as all have on average");
    }
    void run(const Inputs& in, Outputs& out, Context&) const {
        const Samples& samples = in.get<Samples>("samples");
        Image image(samples.width, samples.height, 3);
        image.color_space = samples.color_space;
        const double mean = samples.mean_spp();
        for (size_t p = 0; p < samples.pixels() && mean > 0; ++p) {
            const Samples::Range range = samples.of_pixel(p);
            for (size_t c = 0; c < 3; ++c)
                image.at(int(p % size_t(samples.width)), int(p / size_t(samples.width)))[c] =
                    float(double(range.end - range.begin) / mean);
        }
        out.set("image", std::move(image));
    }
};

WEFT_NODE(CountSamples, "count-samples", 1)

}  // namespace
}  // namespace weft
