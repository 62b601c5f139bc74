// ocio-display: a scene-linear picture made for looking at, by a display and a view of an
// OpenColorIO config. Values outside [0, 1] stay; the file format that cannot hold them clamps.
#include "color/apply_color.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct OcioDisplay {
    std::string display, view, looks, from;
    InputFile config;

    static void declare(Ports<OcioDisplay>& node) {
        node.about("turns a scene-linear picture into display values")
            .in<Image>("image", "a scene-linear picture")
            .out<Image>("image", "what the display is to be sent")
            .param("display", &OcioDisplay::display,
                   {.about = "of the config ('sRGB', 'Rec.709', 'Display P3', 'Rec.2100-PQ'); "
                             "empty: its default"})
            .param("view", &OcioDisplay::view,
                   {.about = "of the display ('ACES 1.0 SDR', 'Un-tone-mapped', 'Raw'); empty: its "
                             "default"})
            .param("looks", &OcioDisplay::looks,
                   {.about = "in place of the view's own; empty: those"})
            .param("from", &OcioDisplay::from,
                   {.about = "instead of the picture's own space; empty: its own"})
            .optional_file("config", &OcioDisplay::config,
                           {.about = "an OpenColorIO config; empty: $OCIO, or the one Weft ships"});
    }

    Cost cost(const Shapes& in) const { return cost_like(in, "image", "image", 0, 0, 500); }

    std::vector<std::string> reads() const { return ColorConfig::further_files(config.path); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& image = in.get<Image>("image");
        const auto colors = ColorConfig::open(config.path);
        Image result = apply_color(
            image, colors->display(space_of(image, from, ctx), display, view, looks), ctx);
        result.attributes["weft:ocio"] = colors->label();
        out.set("image", std::move(result));
    }
};

WEFT_NODE(OcioDisplay, "ocio-display", 1);

}  // namespace
}  // namespace weft
