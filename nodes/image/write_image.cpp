// write-image: a picture to a file; the format is the extension's. Scene-linear pictures go to EXR,
// display pictures (ocio-display) to PNG, JPEG, TIFF. The file says how it was made: the graph, its
// inputs and the program's version stand in its header.
#include "image/color_tags.h"
#include "image/image_cost.h"
#include "image/picture_file.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct WriteImage {
    OutputFile file;
    Depth depth = Depth::automatic;
    Compression compression = Compression::automatic;
    int level = 0;
    int quality = 92;
    bool provenance = true;

    static void declare(Ports<WriteImage>& node) {
        node.about(
                "writes a picture; the extension chooses the format (exr, png, tif, jpg, hdr, pfm "
                "...)")
            .in<Image>("image", "scene-linear for EXR, display values for PNG and JPEG")
            .param("file", &WriteImage::file,
                   {.about = "where to; missing folders are made", .required = true})
            .choice("depth", &WriteImage::depth, {"default", "half", "float", "8", "16"},
                    {.about = "of a channel; default: float for EXR, 8 for PNG and JPEG"})
            .choice("compression", &WriteImage::compression,
                    {"default", "none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa",
                     "dwab"},
                    {.about = "of EXR; default: zip"})
            .param(
                "level", &WriteImage::level,
                {.min = 0, .max = 100, .about = "of zip (1 to 9), dwa and PNG; 0: fast for each"})
            .param("quality", &WriteImage::quality,
                   {.min = 1, .max = 100, .about = "of JPEG and WebP"})
            .param("provenance", &WriteImage::provenance,
                   {.about = "write how the picture was made into it"})
            .writes();
    }

    // The file is made in memory, at most as large as the picture and once more while it is packed.
    Cost cost(const Shapes& in) const {
        const Shape from = in["image"];
        return {{}, 2 * from.bytes, 500.0 * double(from.width) * double(from.height)};
    }

    void run(const Inputs& in, Outputs&, Context& ctx) const {
        const Image& image = in.get<Image>("image");
        PictureOptions options{depth, compression, level, quality, {}};
        if (provenance) options.provenance = ctx.provenance();
        std::vector<std::string> warnings;
        write_picture(file.path, image, options, warnings);
        for (const std::string& warning : warnings) ctx.warn(file.path + ": " + warning);
    }
};

WEFT_NODE(WriteImage, "write-image", 1);

}  // namespace
}  // namespace weft
