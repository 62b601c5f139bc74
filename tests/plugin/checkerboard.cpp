// checkerboard: a picture of squares in two greys.
#include "image/image.h"
#include "runtime/node.h"

namespace {
using namespace weft;

struct Checkerboard {
    int width = 64, height = 64, square = 8;
    float dark = 0.1f, light = 0.8f;

    static void declare(Ports<Checkerboard>& node) {
        node.about("A picture of squares in two greys.")
            .out<Image>("image", "R G B")
            .param("width", &Checkerboard::width, {.unit = "px", .min = 1, .max = 16384, .about = "size"})
            .param("height", &Checkerboard::height, {.unit = "px", .min = 1, .max = 16384, .about = "size"})
            .param("square", &Checkerboard::square, {.unit = "px", .min = 1, .about = "side of a square"})
            .param("dark", &Checkerboard::dark, {.min = 0, .about = "radiance of the squares at odd places"})
            .param("light", &Checkerboard::light, {.min = 0, .about = "radiance of the others"});
    }

    void run(const Inputs&, Outputs& out, Context& ctx) const {
        Image image(width, height, 3);
        image.color_space = "lin_rec709";
        ctx.parallel_rows(height, [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < width; ++x)
                    for (int c = 0; c < 3; ++c) image.at(x, y)[c] = (x / square + y / square) % 2 ? dark : light;
        });
        out.set("image", std::move(image));
    }
};
WEFT_NODE(Checkerboard, "checkerboard", 1)

}  // namespace
