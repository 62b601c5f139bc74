// What the nodes of the sheared filter share, whatever way they sum: parameters, and what samples
// and slopes must fit together.
#pragma once
#include <fmt/format.h>

#include "adaptive/sheared_filter_kernel.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft::adaptive {

struct ShearedNode {
    float across = ShearedSettings{}.across, along = ShearedSettings{}.along,
          cap = ShearedSettings{}.cap, wide = ShearedSettings{}.wide, gain = ShearedSettings{}.gain;
    enum class Fallback { pixel_mean, none };
    Fallback fallback = Fallback::pixel_mean;

    template <class Node>
    static void declare_shared(Ports<Node>& node) {
        const auto of = [](auto ShearedNode::*field) {
            return static_cast<
                std::remove_reference_t<decltype(std::declval<Node>().*field)> Node::*>(field);
        };
        node.template out<Image>("image", "R G B")
            .template out<Image>("effective",
                                 "samples that had a say in each pixel, by their weights; 0 where "
                                 "it kept its own mean")
            .param("across", of(&ShearedNode::across),
                   {.min = 0,
                    .max = 10,
                    .about = "widens the pixel, in parts of the wavelength at the band limit"})
            .param("along", of(&ShearedNode::along),
                   {.min = 0.001,
                    .max = 100,
                    .about = "how far samples are slid, in cycles of what shearing leaves"})
            .param("cap", of(&ShearedNode::cap),
                   {.min = 0.5, .max = 10, .about = "Gaussians end at so many deviations"})
            .param("wide", of(&ShearedNode::wide),
                   {.unit = "px",
                    .min = 0,
                    .max = 1e6,
                    .about = "slopes that differ by more, about 0, leave nothing to gain"})
            .param("gain", of(&ShearedNode::gain),
                   {.min = 1,
                    .max = 1e6,
                    .about = "times its own samples that a pixel must get of others to take them"})
            .choice("fallback", of(&ShearedNode::fallback), {"pixel-mean", "none"},
                    {.about = "what such pixels get, and those where few samples would have a "
                              "say; none: the filter, whatever comes"});
    }
    static Cost cost_for(const Shapes& in, double scratch, double work) {
        const Shape s = in["samples"];
        return {{{"image", image_shape(s.width, s.height, 3)},
                 {"effective", image_shape(s.width, s.height, 1)}},
                scratch * double(s.records),
                work * double(s.records)};
    }

    ShearedSettings settings(bool pieces) const {
        return {across, along, cap, wide, gain, fallback == Fallback::pixel_mean, pieces};
    }
    static void check(const Samples& samples, const Image& slopes, std::string_view who,
                      Context& ctx) {
        samples.require(who, {"xy", "z", "rgb"});
        if (slopes.width() != samples.width || slopes.height() != samples.height)
            ctx.fail(fmt::format("'slopes' is {} x {}, the samples {} x {}; expected one size",
                                 slopes.width(), slopes.height(), samples.width, samples.height));
        if (samples.domain != "camera")
            ctx.fail(
                fmt::format("needs a camera's samples, these are of domain '{}'; for a "
                            "light's visibility there is sheared-visibility",
                            samples.domain));
    }
};

// The two pictures that these nodes make.
struct ShearedPictures {
    explicit ShearedPictures(const Samples& samples)
        : image(samples.width, samples.height, 3), effective(samples.width, samples.height, 1) {
        image.color_space = samples.color_space;
        effective.color_space = "Raw";
    }
    void set(int x, int y, const ShearedFilter::Pixel& pixel) {
        for (int c = 0; c < 3; ++c) image.at(x, y)[c] = float(pixel.rgb[c]);
        *effective.at(x, y) = pixel.own_mean ? 0 : pixel.effective;
    }
    void give(Outputs& out) {
        if (out.wanted("effective")) out.set("effective", std::move(effective));
        if (out.wanted("image")) out.set("image", std::move(image));
    }
    Image image, effective;
};

// Says how many pixels got nothing.
inline void warn_of_empty(size_t empty, const Samples& samples, Context& ctx) {
    if (empty > 0)
        ctx.warn(fmt::format("{} of {} pixels have no sample near; they are black", empty,
                             samples.pixels()));
}

}  // namespace weft::adaptive
