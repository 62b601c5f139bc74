// crop: a rectangle of a picture, enlarged by whole pixels where asked for.
#include <fmt/format.h>

#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct Crop {
    int x = 0, y = 0, width = 0, height = 0, zoom = 1;

    static void declare(Ports<Crop>& node) {
        node.about("cuts a rectangle out of a picture")
            .in<Image>("image", "a picture")
            .out<Image>("image", "the rectangle, same channels and colour space")
            .param("x", &Crop::x, {.unit = "px", .min = 0, .about = "left edge"})
            .param("y", &Crop::y, {.unit = "px", .min = 0, .about = "top edge"})
            .param("width", &Crop::width,
                   {.unit = "px", .min = 0, .about = "0: up to the right edge"})
            .param("height", &Crop::height,
                   {.unit = "px", .min = 0, .about = "0: down to the bottom edge"})
            .param("zoom", &Crop::zoom,
                   {.min = 1, .max = 64, .about = "pixels out a pixel in, across and down"});
    }

    Cost cost(const Shapes& in) const {
        const Shape from = in["image"];
        const std::int64_t w = width > 0 ? width : from.width - x,
                           h = height > 0 ? height : from.height - y;
        if (from.width < 1) return {};
        return {{{"image", image_shape(w * zoom, h * zoom, from.channels)}},
                0,
                double(w * h * zoom * zoom)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& image = in.get<Image>("image");
        const int w = width > 0 ? width : image.width() - x,
                  h = height > 0 ? height : image.height() - y;
        if (w < 1 || h < 1 || x > image.width() - w || y > image.height() - h)
            ctx.fail(
                fmt::format("the rectangle {}, {} + {} x {} does not lie in the picture of {} x {}",
                            x, y, w, h, image.width(), image.height()));
        Image cut(w * zoom, h * zoom, image.names());
        cut.color_space = image.color_space;
        cut.display = image.display;
        cut.view = image.view;
        cut.attributes = image.attributes;
        ctx.parallel_rows(cut.height(), [&](Rows rows) {
            for (int row = rows.begin; row < rows.end; ++row)
                for (int column = 0; column < cut.width(); ++column)
                    std::copy_n(image.at(x + column / zoom, y + row / zoom), image.channels(),
                                cut.at(column, row));
        });
        out.set("image", std::move(cut));
    }
};

WEFT_NODE(Crop, "crop", 1);

}  // namespace
}  // namespace weft
