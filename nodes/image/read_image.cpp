// read-image: a picture from a file, told apart by content: EXR and PNG at once, every other format
// that OpenImageIO reads through a module that is loaded then.
#include "image/image_cost.h"
#include "image/picture_file.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct ReadImage {
    InputFile file;
    std::string color_space;
    std::string part;

    static void declare(Ports<ReadImage>& node) {
        node.about("reads a picture (EXR, PNG, TIFF, JPEG, HDR, PFM ...)")
            .out<Image>("image", "the picture, alpha premultiplied")
            .param("file", &ReadImage::file, {.about = "the picture", .required = true})
            .param("color-space", &ReadImage::color_space,
                   {.about = "the space its values are in; empty: what the file says"})
            .param("part", &ReadImage::part, {.about = "of a multi-part EXR; empty: the first"});
    }

    Cost cost(const Shapes&) const {
        const Shape shape = picture_shape(file.path);
        return {
            {{"image", shape}}, shape.bytes, 500.0 * double(shape.width) * double(shape.height)};
    }

    void run(const Inputs&, Outputs& out, Context&) const {
        out.set("image", read_picture(file.path, {part, color_space}));
    }
};

WEFT_NODE(ReadImage, "read-image", 1);

}  // namespace
}  // namespace weft
