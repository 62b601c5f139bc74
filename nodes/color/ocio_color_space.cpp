// ocio-color-space: from one colour space of an OpenColorIO config to another.
#include "color/apply_color.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct OcioColorSpace {
    std::string from, to = "scene_linear";
    InputFile config;

    static void declare(Ports<OcioColorSpace>& node) {
        node.about("converts a picture to another colour space")
            .in<Image>("image", "a picture")
            .out<Image>("image", "the same in the other space")
            .param("to", &OcioColorSpace::to, {.about = "a space, alias or role of the config"})
            .param("from", &OcioColorSpace::from,
                   {.about = "instead of the picture's own; empty: its own"})
            .optional_file("config", &OcioColorSpace::config,
                           {.about = "an OpenColorIO config; empty: $OCIO, or the one Weft ships"});
    }

    Cost cost(const Shapes& in) const { return cost_like(in, "image", "image", 0, 0, 500); }

    std::vector<std::string> reads() const { return ColorConfig::further_files(config.path); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& image = in.get<Image>("image");
        const auto colors = ColorConfig::open(config.path);
        Image result = apply_color(image, colors->convert(space_of(image, from, ctx), to), ctx);
        result.attributes["weft:ocio"] = colors->label();
        out.set("image", std::move(result));
    }
};

WEFT_NODE(OcioColorSpace, "ocio-color-space", 1);

}  // namespace
}  // namespace weft
