// analytic-reference: the picture of a built-in scene, from so many samples that it can stand for
// the truth. Samples are summed as they are made: memory does not grow with spp.
#include "image/image_bytes.h"
#include "samples/analytic_node.h"

namespace weft {
namespace {

struct AnalyticReference : AnalyticNode {
    int spp = 256;

    static void declare(Ports<AnalyticReference>& node) {
        node.about("the mean of many samples a pixel of a built-in scene: its reference picture")
            .out<Image>("image", "R G B, scene-linear, box filter over pixel, lens and shutter")
            .param("spp", &AnalyticReference::spp,
                   {.unit = "samples", .min = 1, .max = 1 << 20, .about = "samples a pixel"});
        declare_shared(node);
    }

    Cost cost(const Shapes&) const {
        const double pixels = double(width) * height;
        return {{{"image", {width, height, 3, 0, pixels * 12}}}, pixels * 24, pixels * spp * 1000};
    }

    void run(const Inputs&, Outputs& out, Context& ctx) const {
        out.set("image", analytic_reference(scene_name(), options(spp), spp, ctx));
    }

    void piece(const Inputs&, size_t index, ByteWriter& to, Context& ctx) const {
        put_image(to, analytic_reference(scene_name(), options_of_piece(spp, index), spp, ctx));
    }
    void join(const Pieces& all, Outputs& out, Context&) const {
        ImageStack image;
        for (size_t i = 0; i < all.size(); ++i) {
            ByteReader from = all.read(i);
            image.add(take_image(from));
        }
        out.set("image", image.whole());
    }
};

WEFT_NODE(AnalyticReference, "analytic-reference", 1);

}  // namespace
}  // namespace weft
