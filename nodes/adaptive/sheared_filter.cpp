// sheared-filter: motion blur and defocus by a filter sheared along what moves, or is out of focus
// (sheared_filter_kernel.h).
#include <fmt/format.h>

#include <atomic>

#include "adaptive/sheared_filter_kernel.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

struct ShearedFilterNode {
    ShearedSettings settings;
    float across = settings.across, along = settings.along, cap = settings.cap,
          wide = settings.wide, gain = settings.gain;
    enum class Fallback { pixel_mean, none };
    Fallback fallback = Fallback::pixel_mean;

    static void declare(Ports<ShearedFilterNode>& node) {
        node.about(
                "means of the samples that the mean slope of each pixel carries into it, over lens "
                "and shutter")
            .in<Samples>("samples", "xy, z, rgb (t, motion; uv and a lens; weight)")
            .in<Image>("slopes", "of slope-bounds")
            .out<Image>("image", "R G B")
            .out<Image>("effective",
                        "samples that had a say in each pixel, by their weights; 0 where it kept "
                        "its own mean")
            .param("across", &ShearedFilterNode::across,
                   {.min = 0,
                    .max = 10,
                    .about = "widens the pixel, in parts of the wavelength at the band limit"})
            .param("along", &ShearedFilterNode::along,
                   {.min = 0.001,
                    .max = 100,
                    .about = "how far samples are slid, in cycles of what shearing leaves"})
            .param("cap", &ShearedFilterNode::cap,
                   {.min = 0.5, .max = 10, .about = "Gaussians end at so many deviations"})
            .param("wide", &ShearedFilterNode::wide,
                   {.unit = "px",
                    .min = 0,
                    .max = 1e6,
                    .about = "slopes that differ by more, about 0, leave nothing to gain"})
            .param("gain", &ShearedFilterNode::gain,
                   {.min = 1,
                    .max = 1e6,
                    .about = "times its own samples that a pixel must get of others to take them"})
            .choice("fallback", &ShearedFilterNode::fallback, {"pixel-mean", "none"},
                    {.about = "what such pixels get, and those where few samples would have a "
                              "say; none: the filter, whatever comes"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"image", image_shape(s.width, s.height, 3)},
                 {"effective", image_shape(s.width, s.height, 1)}},
                0,
                2000.0 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const Image& slopes = in.get<Image>("slopes");
        samples.require("sheared-filter", {"xy", "z", "rgb"});
        if (slopes.width() != samples.width || slopes.height() != samples.height)
            ctx.fail(fmt::format("'slopes' is {} x {}, the samples {} x {}; expected one size",
                                 slopes.width(), slopes.height(), samples.width, samples.height));
        if (samples.domain != "camera")
            ctx.fail(
                fmt::format("needs a camera's samples, these are of domain '{}'; for a "
                            "light's visibility there is sheared-visibility",
                            samples.domain));
        ShearedSettings with{across, along, cap, wide, gain, fallback == Fallback::pixel_mean};
        const ShearedFilter filter(samples, &slopes, with);
        const SlopeReader slopes_held(slopes, "sheared-filter");
        const bool moves = slopes_held.motion() && samples.has_motion(),
                   blurs = slopes_held.lens() && samples.has_lens();
        if (!moves && !blurs)
            ctx.warn(
                "neither motion nor a lens is in both samples and slopes; the picture is the box "
                "filter's");
        Image image(samples.width, samples.height, 3), effective(samples.width, samples.height, 1);
        image.color_space = samples.color_space;
        effective.color_space = "Raw";
        std::atomic<size_t> empty = 0, done = 0;
        ctx.parallel_rows(
            samples.height,
            [&](Rows rows) {
                for (int y = rows.begin; y < rows.end; ++y) {
                    ctx.check_cancelled();
                    for (int x = 0; x < samples.width; ++x) {
                        const ShearedFilter::Pixel pixel = filter.filtered(x, y);
                        for (int c = 0; c < 3; ++c) image.at(x, y)[c] = float(pixel.rgb[c]);
                        *effective.at(x, y) = pixel.own_mean ? 0 : pixel.effective;
                        empty += !(pixel.effective > 0);
                    }
                    ctx.progress(double(++done), samples.height, "rows");
                }
            },
            1);
        if (empty > 0)
            ctx.warn(fmt::format("{} of {} pixels have no sample near; they are black",
                                 size_t(empty), samples.pixels()));
        if (out.wanted("effective")) out.set("effective", std::move(effective));
        if (out.wanted("image")) out.set("image", std::move(image));
    }
};

WEFT_NODE(ShearedFilterNode, "sheared-filter", 1)

}  // namespace
}  // namespace weft
