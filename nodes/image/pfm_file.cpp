#include "image/pfm_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstring>

#include "graph/error.h"

namespace weft {
namespace {

// The next word of the header and the one white space after it.
std::string_view word(std::string_view& rest) {
    const size_t begin = rest.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return {};
    const size_t end = rest.find_first_of(" \t\r\n", begin);
    if (end == std::string_view::npos) return {};
    const std::string_view found = rest.substr(begin, end - begin);
    rest.remove_prefix(end + 1);
    return found;
}

template <class T>
bool read_number(std::string_view text, T& value) {
    return std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
}

}  // namespace

bool is_pfm(std::string_view bytes) {
    return bytes.size() > 2 && bytes[0] == 'P' && (bytes[1] == 'F' || bytes[1] == 'f') &&
           (bytes[2] == '\n' || bytes[2] == '\r' || bytes[2] == ' ');
}

std::string encode_pfm(const Image& image, std::vector<std::string>& warnings) {
    const int rgb[3] = {image.find("R"), image.find("G"), image.find("B")};
    const bool color = rgb[0] >= 0 && rgb[1] >= 0 && rgb[2] >= 0;
    const int grey = image.channels() == 1 ? 0 : image.find("Y");
    if (!color && grey < 0)
        throw Error(fmt::format("PFM holds R G B or one channel; this picture has {}",
                                fmt::join(image.names(), " ")));
    const int used = color ? 3 : 1;
    if (image.channels() > used)
        warnings.push_back(
            fmt::format("PFM has no place for {} of the channels", image.channels() - used));
    std::string bytes =
        fmt::format("{}\n{} {}\n-1.0\n", color ? "PF" : "Pf", image.width(), image.height());
    size_t place = bytes.size();
    bytes.resize(place +
                 size_t(image.width()) * size_t(image.height()) * size_t(used) * sizeof(float));
    for (int y = image.height() - 1; y >= 0; --y)
        for (int x = 0; x < image.width(); ++x)
            for (int c = 0; c < used; ++c, place += sizeof(float))
                std::memcpy(bytes.data() + place, image.at(x, y) + (color ? rgb[c] : grey),
                            sizeof(float));
    return bytes;
}

Image decode_pfm(std::string_view bytes, const std::string& file) {
    std::string_view rest = bytes;
    const bool color = word(rest) == "PF";
    int width = 0, height = 0;
    float scale = 0;
    if (!read_number(word(rest), width) || !read_number(word(rest), height) ||
        !read_number(word(rest), scale) || width < 1 || height < 1 || scale == 0)
        throw Error(fmt::format("{}: not a whole PFM picture: its header is damaged", file));
    const size_t channels = color ? 3 : 1;
    if (double(rest.size()) < double(width) * height * double(channels) * sizeof(float))
        throw Error(fmt::format("{}: not a whole PFM picture: {} bytes for {} x {} pixels", file,
                                rest.size(), width, height));
    Image image(width, height, int(channels));
    const char* from = rest.data();
    for (int y = height - 1; y >= 0; --y)
        for (size_t i = 0; i < image.stride(); ++i, from += sizeof(float)) {
            std::uint32_t bits;
            std::memcpy(&bits, from, sizeof bits);
            if (scale > 0) bits = __builtin_bswap32(bits);
            std::memcpy(image.row(y) + i, &bits, sizeof bits);
        }
    image.color_space = "lin_rec709";
    return image;
}

}  // namespace weft
