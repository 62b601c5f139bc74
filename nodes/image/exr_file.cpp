#include "image/exr_file.h"

#include <Imath/ImathBox.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "graph/error.h"
#include "image/color_tags.h"
#include "image/image_cost.h"

namespace weft {
namespace {

class MemoryOut : public Imf::OStream {
  public:
    MemoryOut() : Imf::OStream("picture") {}
    void write(const char data[], int size) override {
        const size_t end = place_ + size_t(size);
        if (end > bytes.size()) bytes.resize(end);
        std::memcpy(bytes.data() + place_, data, size_t(size));
        place_ = end;
    }
    uint64_t tellp() override { return place_; }
    void seekp(uint64_t place) override { place_ = place; }
    std::string bytes;

  private:
    size_t place_ = 0;
};

class MemoryIn : public Imf::IStream {
  public:
    MemoryIn(std::string_view bytes, const std::string& name)
        : Imf::IStream(name.c_str()), bytes_(bytes) {}
    bool read(char data[], int size) override {
        if (size < 0 || size_t(size) > bytes_.size() - place_) throw Error("it ends too early");
        std::memcpy(data, bytes_.data() + place_, size_t(size));
        place_ += size_t(size);
        return place_ < bytes_.size();
    }
    uint64_t tellg() override { return place_; }
    void seekg(uint64_t place) override { place_ = std::min<size_t>(place, bytes_.size()); }
    void clear() override {}

  private:
    std::string_view bytes_;
    size_t place_ = 0;
};

constexpr std::pair<const char*, Imf::Compression> compressions[] = {
    {"none", Imf::NO_COMPRESSION},   {"rle", Imf::RLE_COMPRESSION},
    {"zips", Imf::ZIPS_COMPRESSION}, {"zip", Imf::ZIP_COMPRESSION},
    {"piz", Imf::PIZ_COMPRESSION},   {"pxr24", Imf::PXR24_COMPRESSION},
    {"b44", Imf::B44_COMPRESSION},   {"b44a", Imf::B44A_COMPRESSION},
    {"dwaa", Imf::DWAA_COMPRESSION}, {"dwab", Imf::DWAB_COMPRESSION}};

Imf::Compression compression_of(Compression c) {
    if (c == Compression::automatic) return Imf::ZIP_COMPRESSION;
    return compressions[int(c) - int(Compression::none)].second;
}

std::string name_of(Imf::Compression c) {
    for (const auto& [name, value] : compressions)
        if (value == c) return name;
    return "unknown";
}

half half_within_range(float value) {
    if (std::isfinite(value)) value = std::clamp(value, -65504.0f, 65504.0f);
    return half(value);
}

// R G B A before the rest within a layer, the unnamed layer first.
bool channel_before(const std::string& a, const std::string& b) {
    const auto split = [](const std::string& name) {
        const size_t dot = name.rfind('.');
        const std::string layer = dot == std::string::npos ? "" : name.substr(0, dot);
        const std::string last = dot == std::string::npos ? name : name.substr(dot + 1);
        constexpr std::string_view order = "RGBA";
        const size_t place = last.size() == 1 ? order.find(last[0]) : std::string_view::npos;
        return std::tuple(layer, std::min(place, order.size()), last);
    };
    return split(a) < split(b);
}

std::vector<std::string> channel_names(const Imf::Header& header) {
    std::vector<std::string> names;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
        names.push_back(c.name());
    std::sort(names.begin(), names.end(), channel_before);
    return names;
}

// Fills in colour space, display, view and text attributes.
template <class Picture>
void read_attributes(const Imf::Header& header, const std::vector<std::string>& channels,
                     Picture& picture) {
    for (auto a = header.begin(); a != header.end(); ++a)
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute()))
            picture.attributes[a.name()] = text->value();
    const auto take = [&](const char* name) {
        const auto found = picture.attributes.find(name);
        if (found == picture.attributes.end()) return std::string();
        std::string value = found->second;
        picture.attributes.erase(found);
        return value;
    };
    for (const char* known : {"name", "type", "view"})
        if (header.hasType() || header.hasName()) take(known);
    picture.color_space = take("oiio:ColorSpace");
    picture.display = take("weft:display");
    picture.view = take("weft:view");
    // OpenImageIO's "Linear" says that there is no curve, but not which primaries.
    if (picture.color_space == "Linear" || picture.color_space == "linear")
        picture.color_space.clear();
    if (!picture.color_space.empty()) return;
    const auto has = [&](const char* name) {
        return std::find(channels.begin(), channels.end(), name) != channels.end();
    };
    if (!has("R") && !has("G") && !has("B") && !has("Y")) {
        picture.color_space = "Raw";
        return;
    }
    picture.color_space = "lin_rec709";  // what OpenEXR says a file without chromaticities is
    if (!Imf::hasChromaticities(header)) return;
    const Imf::Chromaticities& c = Imf::chromaticities(header);
    const std::string space = space_of_primaries(
        {c.red.x, c.red.y, c.green.x, c.green.y, c.blue.x, c.blue.y, c.white.x, c.white.y});
    if (!space.empty()) picture.color_space = space;
}

void refuse_deep(const Imf::Header& header, const std::string& file) {
    if (header.hasType() && Imf::isDeepData(header.type()))
        throw Error(fmt::format(
            "{}: a deep EXR holds samples, not a picture; read it with 'read-samples'", file));
}

int part_index(const Imf::MultiPartInputFile& in, const std::string& part,
               const std::string& file) {
    if (part.empty()) return 0;
    std::string known;
    for (int i = 0; i < in.parts(); ++i) {
        const std::string name = in.header(i).hasName() ? in.header(i).name() : std::to_string(i);
        if (name == part) return i;
        known += (known.empty() ? "" : ", ") + name;
    }
    throw Error(fmt::format("{}: no part '{}'; it has {}", file, part, known));
}

// OpenEXR's own words, without the name of our stream.
template <class Work>
auto guarded(const std::string& file, Work&& work) {
    try {
        return work();
    } catch (const Error& e) {
        const std::string_view text = e.what();
        if (text.starts_with(file)) throw;
        throw Error(fmt::format("{}: not a whole EXR picture: {}", file, text));
    } catch (const std::bad_alloc&) {
        throw Error(fmt::format("{}: not enough memory to read it", file));
    } catch (const std::exception& e) {
        throw Error(fmt::format("{}: not a readable EXR picture: {}", file, e.what()));
    }
}

}  // namespace

std::string encode_exr(const Image& image, const PictureOptions& options,
                       std::vector<std::string>& warnings) {
    if (options.depth == Depth::u8 || options.depth == Depth::u16)
        throw Error("EXR holds half or float, not 8 or 16 bit; set depth to half or float");
    if (image.width() < 1 || image.height() < 1 || image.channels() < 1)
        throw Error(
            fmt::format("an EXR picture needs a pixel and a channel; this one is {} x {} x {}",
                        image.width(), image.height(), image.channels()));
    const bool to_half = options.depth == Depth::half;

    Imf::Header header(image.width(), image.height());
    header.compression() = compression_of(options.compression);
    if (options.level > 0) {
        header.zipCompressionLevel() = std::min(options.level, 9);
        header.dwaCompressionLevel() = float(options.level);
    } else {
        header.zipCompressionLevel() = 4;
    }
    for (const auto& [name, value] : text_to_write(image, options.provenance)) {
        // A name that OpenEXR itself gives another type, or that a header cannot hold.
        if (name.empty() || name.size() > 255 || header.find(name) != header.end()) {
            warnings.push_back(
                fmt::format("attribute '{}' not written: EXR has its own of that name", name));
            continue;
        }
        header.insert(name, Imf::StringAttribute(value));
    }
    if (!image.color_space.empty())
        header.insert("oiio:ColorSpace", Imf::StringAttribute(image.color_space));
    if (const Primaries* p = primaries_of(image.color_space))
        Imf::addChromaticities(header, Imf::Chromaticities({p->rx, p->ry}, {p->gx, p->gy},
                                                           {p->bx, p->by}, {p->wx, p->wy}));

    const size_t channels = size_t(image.channels());
    std::vector<half> halves;
    if (to_half) {
        halves.resize(image.pixels().size());
        std::transform(image.pixels().begin(), image.pixels().end(), halves.begin(),
                       half_within_range);
    }
    Imf::FrameBuffer frame;
    for (size_t c = 0; c < channels; ++c) {
        const Imf::PixelType type = to_half ? Imf::HALF : Imf::FLOAT;
        const size_t size = to_half ? sizeof(half) : sizeof(float);
        // Imf takes a pointer to non-const for reading as for writing; it is only read here.
        char* base = to_half ? reinterpret_cast<char*>(halves.data())
                             : reinterpret_cast<char*>(const_cast<float*>(image.pixels().data()));
        if (header.channels().findChannel(image.names()[c]))
            throw Error(fmt::format("two channels called '{}'", image.names()[c]));
        header.channels().insert(image.names()[c], Imf::Channel(type));
        frame.insert(image.names()[c],
                     Imf::Slice(type, base + c * size, size * channels, size * image.stride()));
    }
    MemoryOut out;
    try {
        Imf::OutputFile file(out, header, 0);
        file.setFrameBuffer(frame);
        file.writePixels(image.height());
    } catch (const std::exception& e) {
        throw Error(fmt::format("EXR cannot hold this picture: {}", e.what()));
    }
    return std::move(out.bytes);
}

Image decode_exr(std::string_view bytes, const std::string& file, const std::string& part) {
    return guarded(file, [&] {
        MemoryIn in(bytes, file);
        Imf::MultiPartInputFile parts(in, 0);
        const int index = part_index(parts, part, file);
        const Imf::Header& header = parts.header(index);
        refuse_deep(header, file);
        const std::vector<std::string> names = channel_names(header);
        const Imath::Box2i data = header.dataWindow(), shown = header.displayWindow();
        const std::int64_t width = std::int64_t(shown.max.x) - shown.min.x + 1;
        const std::int64_t height = std::int64_t(shown.max.y) - shown.min.y + 1;
        const std::int64_t data_width = std::int64_t(data.max.x) - data.min.x + 1;
        const std::int64_t data_height = std::int64_t(data.max.y) - data.min.y + 1;
        // A damaged header must not make us ask for more than such a file could hold.
        const double most = 1e5 * double(bytes.size()) + 1e6;
        if (names.empty() || width < 1 || height < 1 || data_width < 1 || data_height < 1 ||
            4.0 * double(width) * double(height) * double(names.size()) > most ||
            4.0 * double(data_width) * double(data_height) * double(names.size()) > most)
            throw Error(fmt::format("a header of {} x {} pixels and {} channels", width, height,
                                    names.size()));
        for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
            if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
                throw Error(
                    fmt::format("{}: channel '{}' is subsampled, which is not read; "
                                "convert the file to full-size channels",
                                file, c.name()));

        Image window(int(data_width), int(data_height), names);
        Imf::FrameBuffer frame;
        const size_t pixel = sizeof(float) * names.size();
        for (size_t c = 0; c < names.size(); ++c) {
            // Imf wants the address that pixel (0, 0) would have, which may lie outside the memory.
            const std::intptr_t origin =
                reinterpret_cast<std::intptr_t>(window.pixels().data() + c) -
                data.min.x * std::intptr_t(pixel) -
                data.min.y * std::intptr_t(pixel) * std::intptr_t(data_width);
            frame.insert(names[c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(origin), pixel,
                                              pixel * size_t(data_width)));
        }
        Imf::InputPart input(parts, index);
        input.setFrameBuffer(frame);
        input.readPixels(data.min.y, data.max.y);

        if (data == shown) {
            read_attributes(header, names, window);
            return window;
        }
        Image image(int(width), int(height), names);
        read_attributes(header, names, image);
        const int x0 = std::max(data.min.x, shown.min.x), x1 = std::min(data.max.x, shown.max.x);
        const int y0 = std::max(data.min.y, shown.min.y), y1 = std::min(data.max.y, shown.max.y);
        for (int y = y0; y <= y1 && x0 <= x1; ++y)
            std::copy_n(window.at(x0 - data.min.x, y - data.min.y),
                        size_t(x1 - x0 + 1) * names.size(),
                        image.at(x0 - shown.min.x, y - shown.min.y));
        return image;
    });
}

Shape exr_shape(const std::string& path) {
    const Imf::MultiPartInputFile parts(path.c_str(), 0);
    const Imf::Header& header = parts.header(0);
    const Imath::Box2i shown = header.displayWindow();
    return image_shape(std::int64_t(shown.max.x) - shown.min.x + 1,
                       std::int64_t(shown.max.y) - shown.min.y + 1,
                       std::int64_t(channel_names(header).size()));
}

PictureInfo exr_info(std::string_view bytes, const std::string& file) {
    return guarded(file, [&] {
        MemoryIn in(bytes, file);
        Imf::MultiPartInputFile parts(in, 0);
        const Imf::Header& header = parts.header(0);
        PictureInfo info;
        info.format = header.hasType() && Imf::isDeepData(header.type()) ? "deep EXR" : "EXR";
        const Imath::Box2i shown = header.displayWindow();
        info.width = shown.max.x - shown.min.x + 1;
        info.height = shown.max.y - shown.min.y + 1;
        info.channels = channel_names(header);
        info.compression = name_of(header.compression());
        for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
            const char* depth = c.channel().type == Imf::HALF    ? "half"
                                : c.channel().type == Imf::FLOAT ? "float"
                                                                 : "32 bit whole numbers";
            if (info.depth.empty()) info.depth = depth;
            if (info.depth != depth) info.depth = "mixed";
        }
        for (int i = 0; parts.parts() > 1 && i < parts.parts(); ++i)
            info.parts.push_back(parts.header(i).hasName() ? parts.header(i).name()
                                                           : std::to_string(i));
        read_attributes(header, info.channels, info);
        return info;
    });
}

}  // namespace weft
