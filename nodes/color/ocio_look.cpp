// ocio-look: one or more looks of an OpenColorIO config; the picture stays in its space.
#include "color/apply_color.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct OcioLook {
    std::string looks, from;
    bool inverse = false;
    InputFile config;

    static void declare(Ports<OcioLook>& node) {
        node.about("applies looks of an OpenColorIO config")
            .in<Image>("image", "a picture")
            .out<Image>("image", "the same with the looks on it")
            .param(
                "looks", &OcioLook::looks,
                {.about = "names, by comma; '-name' undoes one, 'a | b' takes b where a is missing",
                 .required = true})
            .param("inverse", &OcioLook::inverse, {.about = "undo them all"})
            .param("from", &OcioLook::from,
                   {.about = "instead of the picture's own space; empty: its own"})
            .optional_file("config", &OcioLook::config,
                           {.about = "an OpenColorIO config; empty: $OCIO, or the one Weft ships"});
    }

    Cost cost(const Shapes& in) const { return cost_like(in, "image", "image", 0, 0, 500); }

    std::vector<std::string> reads() const { return ColorConfig::further_files(config.path); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& image = in.get<Image>("image");
        const auto colors = ColorConfig::open(config.path);
        Image result =
            apply_color(image, colors->look(space_of(image, from, ctx), looks, inverse), ctx);
        result.color_space = image.color_space;
        result.display = image.display;
        result.view = image.view;
        result.attributes["weft:ocio"] = colors->label();
        out.set("image", std::move(result));
    }
};

WEFT_NODE(OcioLook, "ocio-look", 1);

}  // namespace
}  // namespace weft
