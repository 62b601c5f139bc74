#include "image/image_bytes.h"

#include <algorithm>
#include <limits>

namespace weft {

void put_image(ByteWriter& to, const Image& image) {
    to.put(std::int32_t(image.width()));
    to.put(std::int32_t(image.height()));
    to.put(std::uint32_t(image.names().size()));
    for (const std::string& name : image.names()) to.put_text(name);
    to.put_text(image.color_space);
    to.put_text(image.display);
    to.put_text(image.view);
    to.put(std::uint32_t(image.attributes.size()));
    for (const auto& [name, value] : image.attributes) {
        to.put_text(name);
        to.put_text(value);
    }
    to.put_all(image.pixels());
}

Image take_image(ByteReader& from) {
    const auto width = from.take<std::int32_t>(), height = from.take<std::int32_t>();
    const auto channels = from.take<std::uint32_t>();
    std::vector<std::string> names;
    for (std::uint32_t c = 0; c < channels; ++c) names.push_back(from.take_text());
    const std::string color_space = from.take_text(), display = from.take_text(),
                      view = from.take_text();
    std::map<std::string, std::string> attributes;
    for (auto left = from.take<std::uint32_t>(); left > 0; --left) {
        std::string name = from.take_text();
        attributes[std::move(name)] = from.take_text();
    }
    const std::vector<float> pixels = from.take_all<float>();
    if (width < 0 || height < 0 ||
        (width > 0 && channels > 0 && pixels.size() / size_t(width) / channels != size_t(height)) ||
        pixels.size() != size_t(width) * size_t(height) * channels)
        throw Error("holds a picture of another size than it says");
    Image image(width, height, std::move(names));
    std::copy(pixels.begin(), pixels.end(), image.pixels().begin());
    image.color_space = color_space;
    image.display = display;
    image.view = view;
    image.attributes = std::move(attributes);
    return image;
}

void ImageStack::add(Image band) {
    if (!bands_.empty() &&
        (band.width() != bands_.front().width() || band.names() != bands_.front().names()))
        throw Error("holds a band of a picture with another width or other channels");
    if (band.height() > std::numeric_limits<int>::max() - height_)
        throw Error("holds a picture that is too high");
    height_ += band.height();
    bands_.push_back(std::move(band));
}

Image ImageStack::whole() {
    if (bands_.empty()) return {};
    const Image& first = bands_.front();
    Image image(first.width(), height_, first.names());
    image.color_space = first.color_space;
    image.display = first.display;
    image.view = first.view;
    image.attributes = first.attributes;
    auto to = image.pixels().begin();
    for (const Image& band : bands_) to = std::copy(band.pixels().begin(), band.pixels().end(), to);
    return image;
}

}  // namespace weft
