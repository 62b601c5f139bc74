// The module weft_oiio: pictures through OpenImageIO. One thread: the runtime's loops are ours.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "graph/error.h"
#include "image/color_tags.h"
#include "image/oiio_open.h"
#include "image/other_formats.h"

namespace weft {
namespace {

// What our spaces are called by OpenImageIO 2.4, and the other way round.
std::string to_oiio(const Image& image) {
    if (is_scene_linear(image.color_space)) return "Linear";
    const DisplayTag* tag = display_tag(image.color_space);
    if (!tag) tag = display_tag(image.display);
    if (tag && tag->srgb) return "sRGB";
    if (tag && tag->transfer == 1) return "Rec709";
    return {};
}

std::vector<std::string> names_of(const OIIO::ImageSpec& spec) {
    if (spec.nchannels == 1) return {"Y"};
    if (spec.nchannels == 2 && spec.alpha_channel == 1) return {"Y", "A"};
    return spec.channelnames;
}

// Attributes that say how a file was stored, not what the picture is.
bool about_the_file(OIIO::ustring name) {
    for (const char* known : {"oiio:ColorSpace", "compression", "planarconfig", "DateTime"})
        if (name == known) return true;
    return false;
}

template <class Picture>
void read_attributes(const OIIO::ImageSpec& spec, Picture& picture) {
    picture.color_space = from_oiio(spec.get_string_attribute("oiio:ColorSpace"),
                                    spec.format.basetype < OIIO::TypeDesc::HALF);
    for (const OIIO::ParamValue& value : spec.extra_attribs)
        if (value.type() == OIIO::TypeString && !about_the_file(value.name()))
            picture.attributes[value.name().string()] = value.get_string();
}

// A file in memory that only its path in /proc leads to.
class MemoryFile {
  public:
    MemoryFile() : file_(memfd_create("picture", MFD_CLOEXEC)) {
        if (file_ < 0) throw Error("no memory for a picture");
    }
    ~MemoryFile() { close(file_); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    std::string path() const { return fmt::format("/proc/self/fd/{}", file_); }
    std::string bytes() const {
        std::string all(size_t(lseek(file_, 0, SEEK_END)), 0);
        if (pread(file_, all.data(), all.size(), 0) != ssize_t(all.size()))
            throw Error("a picture in memory was lost");
        return all;
    }

  private:
    int file_;
};

class ThroughOpenImageIO final : public OtherFormats {
  public:
    ThroughOpenImageIO() {
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", 1);
    }

    Image decode(std::string_view bytes, const std::string& file) const override {
        Opened opened;
        open(bytes, file, opened);
        const OIIO::ImageSpec spec = opened.input->spec();
        const double size = 4.0 * spec.width * double(spec.height) * spec.nchannels;
        if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 ||
            size > 1e5 * double(bytes.size()) + 1e6)
            throw Error(
                fmt::format("{}: not a whole picture: a header of {} x {} pixels and {} channels",
                            file, spec.width, spec.height, spec.nchannels));
        Image image(spec.width, spec.height, names_of(spec));
        if (!opened.input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT,
                                      image.pixels().data()))
            throw Error(
                fmt::format("{}: not a whole picture: {}", file, told(opened.input->geterror())));
        read_attributes(spec, image);
        return image;
    }

    PictureInfo info(std::string_view bytes, const std::string& file) const override {
        Opened opened;
        open(bytes, file, opened);
        const OIIO::ImageSpec& spec = opened.input->spec();
        PictureInfo info;
        info.format = opened.input->format_name();
        info.width = spec.width;
        info.height = spec.height;
        info.channels = names_of(spec);
        info.depth = spec.format == OIIO::TypeDesc::HALF ? "half"
                     : spec.format == OIIO::TypeDesc::FLOAT
                         ? "float"
                         : fmt::format("{} bit", spec.format.size() * 8);
        info.compression = spec.get_string_attribute("compression");
        read_attributes(spec, info);
        return info;
    }

    std::string encode(const std::string& extension, const Image& image,
                       const PictureOptions& options,
                       std::vector<std::string>& warnings) const override {
        auto output = OIIO::ImageOutput::create(extension);
        if (!output) throw Error(fmt::format("this OpenImageIO does not write '.{}'", extension));
        const bool linear = is_scene_linear(image.color_space);
        OIIO::TypeDesc type = OIIO::TypeDesc::UINT8;
        switch (options.depth) {
            case Depth::automatic:
                if (extension == "hdr" || (linear && extension.starts_with("tif")))
                    type = OIIO::TypeDesc::FLOAT;
                break;
            case Depth::half:
                type = OIIO::TypeDesc::HALF;
                break;
            case Depth::single:
                type = OIIO::TypeDesc::FLOAT;
                break;
            case Depth::u8:
                break;
            case Depth::u16:
                type = OIIO::TypeDesc::UINT16;
                break;
        }
        OIIO::ImageSpec spec(image.width(), image.height(), image.channels(), type);
        spec.channelnames = image.names();
        const int alpha = image.find("A");
        spec.alpha_channel = alpha;
        const std::string space = to_oiio(image);
        if (!space.empty()) spec.attribute("oiio:ColorSpace", space);
        spec.attribute("CompressionQuality", options.quality);
        // TIFF would put in the time of writing; a fixed one keeps the bytes the same.
        spec.attribute("DateTime", "1980:01:01 00:00:00");
        if (extension.starts_with("tif"))
            for (const auto& [name, value] : text_to_write(image, {}))
                if (name.find(':') == std::string::npos) spec.attribute(name, value);
        if (options.depth != Depth::automatic && extension == "hdr")
            warnings.push_back("HDR has one depth of its own (rgbe)");

        std::vector<float> pixels;
        const float* data = image.pixels().data();
        if (type.is_floating_point() == false) {
            // Clamped here: formats differ in what they make of values that they cannot hold.
            pixels.assign(image.pixels().begin(), image.pixels().end());
            for (float& value : pixels) value = value > 0 ? std::min(value, 1.0f) : 0.0f;
            data = pixels.data();
        }
        const auto fail = [&] {
            throw Error(fmt::format("cannot be written: {}", told(output->geterror())));
        };
        // To memory first: a full disk makes libjpeg end the whole program. TIFF reads back what it
        // wrote, which OpenImageIO's memory cannot: it gets a file without a name.
        const bool reads_back = extension.starts_with("tif");
        OIIO::Filesystem::IOVecOutput bytes;
        MemoryFile file;
        if (!reads_back && !output->set_ioproxy(&bytes)) fail();
        if (!output->open(reads_back ? file.path() : "picture." + extension, spec)) fail();
        if (!output->write_image(OIIO::TypeDesc::FLOAT, data)) fail();
        if (!output->close()) fail();
        if (reads_back) return file.bytes();
        return {bytes.buffer().begin(), bytes.buffer().end()};
    }
};

}  // namespace
}  // namespace weft

const weft::OtherFormats* weft_other_formats() {
    static const weft::ThroughOpenImageIO formats;
    return &formats;
}
