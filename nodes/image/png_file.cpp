#include "image/png_file.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstring>

#include "graph/error.h"
#include "image/color_tags.h"

namespace weft {
namespace {

// libpng reports by callback and must not return from it. Everything that needs a destructor lives
// in these structs, outside the function that calls setjmp.
struct Trouble {
    char message[256] = "damaged data";
    jmp_buf back;
};

void on_error(png_structp png, png_const_charp message) {
    auto* trouble = static_cast<Trouble*>(png_get_error_ptr(png));
    std::snprintf(trouble->message, sizeof trouble->message, "%s", message);
    std::longjmp(trouble->back, 1);
}
void on_warning(png_structp, png_const_charp) {}

struct Writer {
    png_structp png = nullptr;
    png_infop info = nullptr;
    Trouble trouble;
    std::string bytes;
    std::vector<png_bytep> rows;
    std::vector<png_text> texts;
    png_uint_32 width = 0, height = 0;
    int depth = 8, type = PNG_COLOR_TYPE_RGB, level = 1;
    bool strong = false;  // all filters are tried
    const DisplayTag* tag = nullptr;
    bool linear = false;
    png_unknown_chunk cicp = {};

    ~Writer() { png_destroy_write_struct(&png, &info); }
    bool run();
};

void append(png_structp png, png_bytep data, size_t size) {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(data), size);
}

bool Writer::run() {
    if (setjmp(trouble.back)) return false;
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &trouble, on_error, on_warning);
    info = png ? png_create_info_struct(png) : nullptr;
    if (!info) return false;
    png_set_write_fn(png, &bytes, append, nullptr);
    png_set_compression_level(png, level);
    png_set_filter(png, 0, strong ? PNG_ALL_FILTERS : PNG_FILTER_UP);
    png_set_compression_buffer_size(png, 1 << 20);
    png_set_IHDR(png, info, width, height, depth, type, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (tag && tag->srgb) {
        png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_RELATIVE);
    } else if (tag) {
        const Primaries& p = tag->xy;
        png_set_gAMA(png, info, tag->gamma);
        png_set_cHRM(png, info, p.wx, p.wy, p.rx, p.ry, p.gx, p.gy, p.bx, p.by);
        png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_ALWAYS, nullptr, 0);
        png_set_unknown_chunks(png, info, &cicp, 1);
    } else if (linear) {
        png_set_gAMA(png, info, 1.0);
    }
    if (!texts.empty()) png_set_text(png, info, texts.data(), int(texts.size()));
    png_write_info(png, info);
    if (depth == 16) png_set_swap(png);  // rows hold the machine's own order
    png_write_image(png, rows.data());
    png_write_end(png, nullptr);
    return true;
}

// Which channels of a picture make the file's grey (1), grey+alpha (2), RGB (3) or RGBA (4).
std::vector<int> channels_to_write(const Image& image, std::vector<std::string>& warnings) {
    std::vector<int> chosen;
    const int alpha = image.find("A");
    const int r = image.find("R"), g = image.find("G"), b = image.find("B"), grey = image.find("Y");
    if (r >= 0 && g >= 0 && b >= 0)
        chosen = {r, g, b};
    else if (grey >= 0)
        chosen = {grey};
    else if (image.channels() == 1)
        return {0};
    else
        throw Error(fmt::format("PNG holds R G B, R G B A, Y or one channel; this picture has {}",
                                fmt::join(image.names(), " ")));
    if (alpha >= 0) chosen.push_back(alpha);
    std::vector<std::string> left;
    for (int c = 0; c < image.channels(); ++c)
        if (std::find(chosen.begin(), chosen.end(), c) == chosen.end())
            left.push_back(image.names()[size_t(c)]);
    if (!left.empty())
        warnings.push_back(fmt::format("PNG has no place for channels {}", fmt::join(left, " ")));
    return chosen;
}

float within_01(float value) {
    return value > 0 ? std::min(value, 1.0f) : 0.0f;
}  // NaN: 0

template <class Whole>
void quantise(const Image& image, const std::vector<int>& chosen,
              std::vector<unsigned char>& pixels) {
    constexpr float most = float(Whole(~Whole(0)));
    const size_t n = chosen.size();
    const bool alpha = n == 2 || n == 4;
    auto* out = reinterpret_cast<Whole*>(pixels.data());
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x, out += n) {
            const float* in = image.at(x, y);
            float scale = most;
            if (alpha) {
                const float a = within_01(in[chosen[n - 1]]);
                out[n - 1] = Whole(a * most + 0.5f);
                scale = a > 0 ? most / a : 0;
            }
            for (size_t c = 0; c < n - size_t(alpha); ++c)
                out[c] = Whole(std::min(within_01(in[chosen[c]]) * scale, most) + 0.5f);
        }
}

struct Reader {
    png_structp png = nullptr;
    png_infop info = nullptr;
    Trouble trouble;
    std::string_view bytes;
    size_t place = 0;
    bool header_only = false;
    std::vector<unsigned char> pixels;
    std::vector<png_bytep> rows;
    png_uint_32 width = 0, height = 0;
    int depth = 0, type = 0, channels = 0, file_depth = 0;
    bool too_large = false;

    ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
    bool run();
};

void take(png_structp png, png_bytep data, size_t size) {
    auto* reader = static_cast<Reader*>(png_get_io_ptr(png));
    if (size > reader->bytes.size() - reader->place) png_error(png, "it ends too early");
    std::memcpy(data, reader->bytes.data() + reader->place, size);
    reader->place += size;
}

bool Reader::run() {
    if (setjmp(trouble.back)) return false;
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &trouble, on_error, on_warning);
    info = png ? png_create_info_struct(png) : nullptr;
    if (!info) return false;
    png_set_read_fn(png, this, take);
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_ALWAYS, nullptr, 0);
    png_read_info(png, info);
    png_get_IHDR(png, info, &width, &height, &file_depth, &type, nullptr, nullptr, nullptr);
    if (header_only) {
        channels = png_get_channels(png, info);
        return true;
    }
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
    if (file_depth < 8) png_set_expand_gray_1_2_4_to_8(png);
    if (png_get_valid(png, info, PNG_INFO_tRNS)) png_set_tRNS_to_alpha(png);
    if (file_depth == 16) png_set_swap(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    channels = png_get_channels(png, info);
    depth = png_get_bit_depth(png, info);
    const size_t stride = png_get_rowbytes(png, info);
    // zlib packs at most 1032:1, so a larger picture cannot be in these bytes.
    too_large = double(stride) * height > 1100.0 * double(bytes.size()) + 1e6;
    if (too_large) return false;
    pixels.resize(stride * height);
    rows.resize(height);
    for (png_uint_32 y = 0; y < height; ++y) rows[y] = pixels.data() + stride * y;
    png_read_image(png, rows.data());
    png_read_end(png, info);
    return true;
}

void run_reader(Reader& reader, const std::string& file) {
    if (reader.run()) return;
    if (reader.too_large)
        throw Error(fmt::format("{}: not a whole PNG picture: a header of {} x {} pixels", file,
                                reader.width, reader.height));
    throw Error(fmt::format("{}: not a whole PNG picture: {}", file, reader.trouble.message));
}

template <class Picture>
void read_text_and_colour(Reader& reader, Picture& picture) {
    png_textp texts = nullptr;
    const int count = png_get_text(reader.png, reader.info, &texts, nullptr);
    for (int i = 0; i < count; ++i) {
        const size_t size = texts[i].compression >= PNG_ITXT_COMPRESSION_NONE
                                ? texts[i].itxt_length
                                : texts[i].text_length;
        picture.attributes[texts[i].key] = std::string(texts[i].text ? texts[i].text : "", size);
    }
    const auto take_text = [&](const char* name) {
        const auto found = picture.attributes.find(name);
        if (found == picture.attributes.end()) return std::string();
        std::string value = found->second;
        picture.attributes.erase(found);
        return value;
    };
    picture.color_space = take_text("weft:color-space");
    picture.display = take_text("weft:display");
    picture.view = take_text("weft:view");
    if (!picture.color_space.empty()) return;
    picture.color_space = "sRGB - Texture";
    double gamma = 0;
    if (!png_get_valid(reader.png, reader.info, PNG_INFO_sRGB) &&
        png_get_gAMA(reader.png, reader.info, &gamma) && std::abs(gamma - 1) < 1e-3)
        picture.color_space = "lin_rec709";
    png_unknown_chunkp chunks = nullptr;
    const int unknown = png_get_unknown_chunks(reader.png, reader.info, &chunks);
    for (int i = 0; i < unknown; ++i)
        if (!std::memcmp(chunks[i].name, "cICP", 4) && chunks[i].size == 4) {
            const std::string display = display_of_cicp(chunks[i].data[0], chunks[i].data[1]);
            if (!display.empty() && chunks[i].data[1] != 13) picture.color_space = display;
            if (chunks[i].data[0] == 12) picture.color_space = display;
        }
}

std::vector<std::string> names_of(int channels) {
    if (channels == 2) return {"Y", "A"};
    return Image(0, 0, channels).names();
}

}  // namespace

std::string encode_png(const Image& image, const PictureOptions& options,
                       std::vector<std::string>& warnings) {
    if (options.depth == Depth::half || options.depth == Depth::single)
        throw Error("PNG holds 8 or 16 bit, not half or float; set depth to 8 or 16, or write EXR");
    if (image.width() < 1 || image.height() < 1 || image.width() > 1000000 ||
        image.height() > 1000000)
        throw Error(fmt::format("PNG cannot hold a picture of {} x {} pixels", image.width(),
                                image.height()));
    const std::vector<int> chosen = channels_to_write(image, warnings);
    constexpr int types[] = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                             PNG_COLOR_TYPE_RGB_ALPHA};
    Writer writer;
    writer.width = png_uint_32(image.width());
    writer.height = png_uint_32(image.height());
    writer.depth = options.depth == Depth::u16 ? 16 : 8;
    writer.type = types[chosen.size()];
    writer.level = options.level > 0 ? std::min(options.level, 9) : 1;
    writer.strong = options.level >= 5;
    writer.linear = is_scene_linear(image.color_space);
    writer.tag = display_tag(image.color_space);
    if (!writer.tag) writer.tag = display_tag(image.display);
    unsigned char cicp[4] = {0, 0, 0, 1};  // RGB, full range
    if (writer.tag) {
        cicp[0] = writer.tag->primaries;
        cicp[1] = writer.tag->transfer;
        std::memcpy(writer.cicp.name, "cICP", 5);
        writer.cicp.data = cicp;
        writer.cicp.size = 4;
        writer.cicp.location = PNG_HAVE_IHDR;
    }

    const size_t stride = size_t(image.width()) * chosen.size() * size_t(writer.depth / 8);
    std::vector<unsigned char> pixels(stride * size_t(image.height()));
    if (writer.depth == 16)
        quantise<std::uint16_t>(image, chosen, pixels);
    else
        quantise<std::uint8_t>(image, chosen, pixels);
    for (int y = 0; y < image.height(); ++y)
        writer.rows.push_back(pixels.data() + stride * size_t(y));

    std::map<std::string, std::string> text = text_to_write(image, options.provenance);
    if (!image.color_space.empty()) text["weft:color-space"] = image.color_space;
    for (auto& [name, value] : text) {
        if (name.empty() || name.size() > 79) {
            warnings.push_back(
                fmt::format("attribute '{}' not written: PNG's names have 1 to 79 letters", name));
            continue;
        }
        png_text entry = {};
        entry.compression = PNG_ITXT_COMPRESSION_NONE;
        entry.key = const_cast<char*>(name.c_str());
        entry.text = value.data();
        entry.itxt_length = value.size();
        writer.texts.push_back(entry);
    }
    if (!writer.run())
        throw Error(fmt::format("PNG cannot hold this picture: {}", writer.trouble.message));
    return std::move(writer.bytes);
}

Image decode_png(std::string_view bytes, const std::string& file) {
    Reader reader;
    reader.bytes = bytes;
    run_reader(reader, file);
    Image image(int(reader.width), int(reader.height), names_of(reader.channels));
    read_text_and_colour(reader, image);
    const size_t n = size_t(reader.channels), count = image.pixels().size();
    float* out = image.pixels().data();
    if (reader.depth == 16) {
        const auto* in = reinterpret_cast<const std::uint16_t*>(reader.pixels.data());
        for (size_t i = 0; i < count; ++i) out[i] = float(in[i]) / 65535.0f;
    } else {
        for (size_t i = 0; i < count; ++i) out[i] = float(reader.pixels[i]) / 255.0f;
    }
    if (n == 2 || n == 4)
        for (size_t i = 0; i < count; i += n)
            for (size_t c = 0; c + 1 < n; ++c) out[i + c] *= out[i + n - 1];
    return image;
}

PictureInfo png_info(std::string_view bytes, const std::string& file) {
    Reader reader;
    reader.bytes = bytes;
    reader.header_only = true;
    run_reader(reader, file);
    PictureInfo info;
    info.format = "PNG";
    info.width = int(reader.width);
    info.height = int(reader.height);
    info.channels = names_of(reader.type == PNG_COLOR_TYPE_PALETTE ? 3 : reader.channels);
    info.depth = fmt::format("{} bit", reader.file_depth);
    read_text_and_colour(reader, info);
    return info;
}

}  // namespace weft
