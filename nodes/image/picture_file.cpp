#include "image/picture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "graph/diagnostic.h"
#include "graph/error.h"
#include "image/color_tags.h"
#include "image/exr_file.h"
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

PictureKind picture_kind(std::string_view bytes) {
    if (bytes.starts_with("\x76\x2f\x31\x01")) return PictureKind::exr;
    if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return PictureKind::png;
    return PictureKind::other;
}

std::string writable_extensions() {
    return "exr, png";
}

void write_picture(const std::string& path, const Image& image, const PictureOptions& options,
                   std::vector<std::string>& warnings) {
    const std::string extension = extension_of(path);
    try {
        if (extension == "exr") return write_file(path, encode_exr(image, options, warnings));
        if (is_scene_linear(image.color_space))
            warnings.push_back(
                fmt::format("scene-linear values ({}) written as they are to a display format; "
                            "'ocio-display' makes a picture to look at",
                            image.color_space));
        if (extension == "png") return write_file(path, encode_png(image, options, warnings));
        throw Error(
            fmt::format("no way to write '.{}'; known: {}", extension, writable_extensions()));
    } catch (const Error& e) {
        if (std::string_view(e.what()).find(path) != std::string_view::npos) throw;
        throw Error(fmt::format("{}: {}", path, e.what()));
    }
}

Image read_picture(const std::string& path, const ReadPicture& options) {
    const std::string bytes = read_whole_file(path);
    Image image;
    switch (picture_kind(bytes)) {
        case PictureKind::exr:
            image = decode_exr(bytes, path, options.part);
            break;
        case PictureKind::png:
            image = decode_png(bytes, path);
            break;
        case PictureKind::other:
            throw Error(fmt::format("{}: not a picture that is known (EXR, PNG)", path));
    }
    if (!options.color_space.empty()) image.color_space = options.color_space;
    return image;
}

}  // namespace weft
