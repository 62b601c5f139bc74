#include "image/picture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "graph/diagnostic.h"
#include "graph/error.h"
#include "image/color_tags.h"
#include "image/exr_file.h"
#include "image/image_cost.h"
#include "image/other_formats.h"
#include "image/pfm_file.h"
#include "image/png_file.h"
#include "runtime/atomic_file.h"

namespace weft {
namespace {

std::string extension_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return extension;
}

}  // namespace

std::string read_whole_file(const std::string& path) {
    struct Close {
        void operator()(FILE* f) const { std::fclose(f); }
    };
    const auto fail = [&] {
        throw Error(fmt::format("{}: cannot be read: {}", path, std::strerror(errno)));
    };
    if (std::filesystem::is_directory(path)) {
        errno = EISDIR;
        fail();
    }
    std::unique_ptr<FILE, Close> file(std::fopen(path.c_str(), "rb"));
    if (!file) fail();
    std::string bytes;
    std::error_code unknown;
    const auto size = std::filesystem::file_size(path, unknown);
    if (!unknown) bytes.reserve(size_t(size) + 1);
    char piece[1 << 16];
    while (const size_t got = std::fread(piece, 1, sizeof piece, file.get()))
        bytes.append(piece, got);
    if (std::ferror(file.get())) fail();
    return bytes;
}

namespace {

enum class Known { exr, png, pfm, other };

Known known_format(std::string_view bytes) {
    if (bytes.starts_with("\x76\x2f\x31\x01")) return Known::exr;
    if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return Known::png;
    if (is_pfm(bytes)) return Known::pfm;
    return Known::other;
}

bool module_writes(const std::string& extension) {
    const auto& names = other_extensions();
    return std::find(names.begin(), names.end(), extension) != names.end();
}

}  // namespace

bool is_exr_or_png(std::string_view bytes) {
    const Known format = known_format(bytes);
    return format == Known::exr || format == Known::png;
}

std::string writable_extensions() {
    return fmt::format("exr, png, pfm, {}", fmt::join(other_extensions(), ", "));
}

void write_picture(const std::string& path, const Image& image, const PictureOptions& options,
                   std::vector<std::string>& warnings) {
    const std::string extension = extension_of(path);
    try {
        if (extension == "exr") return write_file(path, encode_exr(image, options, warnings));
        if (extension == "pfm") return write_file(path, encode_pfm(image, warnings));
        if (extension != "png" && !module_writes(extension))
            throw Error(
                fmt::format("no way to write '.{}'; known: {}", extension, writable_extensions()));
        if (is_scene_linear(image.color_space) && extension != "hdr" &&
            !extension.starts_with("tif"))
            warnings.push_back(
                fmt::format("scene-linear values ({}) written as they are to a display format; "
                            "'ocio-display' makes a picture to look at",
                            image.color_space));
        if (extension == "png") return write_file(path, encode_png(image, options, warnings));
        write_file(path, other_formats(path).encode(extension, image, options, warnings));
    } catch (const Error& e) {
        if (std::string_view(e.what()).find(path) != std::string_view::npos) throw;
        throw Error(fmt::format("{}: {}", path, e.what()));
    }
}

Image decode_picture(std::string_view bytes, const std::string& file, const ReadPicture& options) {
    Image image;
    switch (known_format(bytes)) {
        case Known::exr:
            image = decode_exr(bytes, file, options.part);
            break;
        case Known::png:
            image = decode_png(bytes, file);
            break;
        case Known::pfm:
            image = decode_pfm(bytes, file);
            break;
        case Known::other:
            if (bytes.empty())
                throw Error(fmt::format("{}: not a picture: the file is empty", file));
            image = other_formats(file).decode(bytes, file);
            break;
    }
    if (!options.color_space.empty()) image.color_space = options.color_space;
    return image;
}

Image read_picture(const std::string& path, const ReadPicture& options) {
    return decode_picture(read_whole_file(path), path, options);
}

Shape picture_shape(const std::string& path) {
    try {
        std::ifstream file(path, std::ios::binary);
        char head[26] = {};
        file.read(head, sizeof head);
        const std::string_view bytes(head, size_t(file.gcount()));
        if (known_format(bytes) == Known::exr) return exr_shape(path);
        if (known_format(bytes) != Known::png || bytes.size() < sizeof head) return {};
        const auto number = [&](size_t place) {
            std::int64_t value = 0;
            for (size_t i = 0; i < 4; ++i)
                value = value << 8 | static_cast<unsigned char>(bytes[place + i]);
            return value;
        };
        constexpr int channels[] = {1, 0, 3, 3, 2, 0, 4};  // by PNG's colour type
        const auto type = static_cast<unsigned char>(bytes[25]);
        return type < std::size(channels) ? image_shape(number(16), number(20), channels[type])
                                          : Shape{};
    } catch (const std::exception&) {
        return {};  // read_picture() says what is wrong
    }
}

PictureInfo picture_info(const std::string& path) {
    const std::string bytes = read_whole_file(path);
    switch (known_format(bytes)) {
        case Known::exr:
            return exr_info(bytes, path);
        case Known::png:
            return png_info(bytes, path);
        case Known::pfm: {
            const Image image = decode_pfm(bytes, path);
            PictureInfo info;
            info.format = "PFM";
            info.width = image.width();
            info.height = image.height();
            info.channels = image.names();
            info.depth = "float";
            info.color_space = image.color_space;
            return info;
        }
        case Known::other:
            break;
    }
    if (bytes.empty()) throw Error(fmt::format("{}: not a picture: the file is empty", path));
    return other_formats(path).info(bytes, path);
}

}  // namespace weft
