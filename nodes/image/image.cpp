#include "image/image.h"

#include <fmt/format.h>

#include "graph/error.h"

namespace weft {
namespace {

std::vector<std::string> usual_names(int channels) {
    switch (channels) {
        case 1:
            return {"Y"};
        case 3:
            return {"R", "G", "B"};
        case 4:
            return {"R", "G", "B", "A"};
        default:
            break;
    }
    std::vector<std::string> names;
    for (int c = 0; c < channels; ++c) names.push_back(fmt::format("c{}", c));
    return names;
}

}  // namespace

Image::Image(int width, int height, int channels) : Image(width, height, usual_names(channels)) {}

Image::Image(int width, int height, std::vector<std::string> channel_names)
    : width_(width), height_(height), names_(std::move(channel_names)) {
    if (width < 0 || height < 0)
        throw Error(fmt::format("a picture of {} x {} pixels cannot be made", width, height));
    pixels_.resize(size_t(width_) * size_t(height_) * names_.size(), 0.0f);
}

Image Image::like(const Image& other) {
    Image image(other.width_, other.height_, other.names_);
    image.color_space = other.color_space;
    image.display = other.display;
    image.view = other.view;
    image.attributes = other.attributes;
    return image;
}

int Image::find(const std::string& channel) const {
    for (size_t c = 0; c < names_.size(); ++c)
        if (names_[c] == channel) return int(c);
    return -1;
}

void Image::describe(FieldVisitor& fields) const {
    fields.field("pixels", std::span<const float>(pixels_), channels());
}

}  // namespace weft
