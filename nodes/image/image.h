// Image: a picture, float, channels interleaved, row by row from the top left.
#pragma once
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "runtime/large_array.h"
#include "runtime/value.h"

namespace weft {

class Image {
  public:
    Image() = default;
    Image(int width, int height, int channels);  // zeros; channels Y, R G B, R G B A, or c0 c1 ...
    Image(int width, int height, std::vector<std::string> channel_names);
    // Same size, channels and attributes, zeros.
    static Image like(const Image& other);

    int width() const { return width_; }
    int height() const { return height_; }
    int channels() const { return int(names_.size()); }
    const std::vector<std::string>& names() const { return names_; }
    int find(const std::string& channel) const;  // index, or -1

    float* row(int y) { return pixels_.data() + size_t(y) * stride(); }
    const float* row(int y) const { return pixels_.data() + size_t(y) * stride(); }
    float* at(int x, int y) { return row(y) + size_t(x) * names_.size(); }
    const float* at(int x, int y) const { return row(y) + size_t(x) * names_.size(); }
    std::span<float> pixels() { return pixels_; }
    std::span<const float> pixels() const { return pixels_; }
    size_t stride() const { return size_t(width_) * names_.size(); }
    size_t bytes() const { return pixels_.size() * sizeof(float); }
    void count(Items& items) const { items.add("pixels", size_t(width_) * size_t(height_)); }
    void describe(FieldVisitor& fields) const;  // "pixels", row by row, a component a channel

    std::string color_space;    // "lin_rec709", "ACEScg"; of a display picture: its display space
    std::string display, view;  // set by ocio-display
    std::map<std::string, std::string> attributes;  // text to be written with the picture

  private:
    int width_ = 0, height_ = 0;
    std::vector<std::string> names_;
    LargeArray<float> pixels_;
};

WEFT_VALUE_TYPE(Image, "Image", "a picture, float, any channels")

}  // namespace weft
