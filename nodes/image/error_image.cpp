// error-image: where a picture differs from its reference, in false colour or as values.
#include "image/image_cost.h"
#include "image/measures.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct ErrorImage {
    ErrorKind error = ErrorKind::flip;
    float range = 1;
    bool values = false;

    static void declare(Ports<ErrorImage>& node) {
        node.about("a picture of the error against a reference")
            .in<Image>("image", "the picture to judge")
            .in<Image>("reference", "the true picture, of the same size and colour space")
            .out<Image>("image", "false colour, sRGB; or one channel 'error'")
            .choice("error", &ErrorImage::error, {"flip", "relative", "absolute"},
                    {.about = "LDR-FLIP; root of (a-b)^2/(b^2+0.01); |a-b|"})
            .param("range", &ErrorImage::range, {.min = 1e-6, .about = "error shown brightest"})
            .param("values", &ErrorImage::values,
                   {.about = "the numbers themselves instead of colours"});
    }

    Cost cost(const Shapes& in) const {
        return cost_like(in, "reference", "image", values ? 1 : 3, 24, 1000);
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& image = in.get<Image>("image");
        const std::vector<float> map = error_map(image, in.get<Image>("reference"), error, ctx);
        if (!values)
            return out.set("image", false_color(map, image.width(), image.height(), range));
        Image plain(image.width(), image.height(), std::vector<std::string>{"error"});
        std::copy(map.begin(), map.end(), plain.pixels().begin());
        plain.color_space = "Raw";
        out.set("image", std::move(plain));
    }
};

WEFT_NODE(ErrorImage, "error-image", 1);

}  // namespace
}  // namespace weft
