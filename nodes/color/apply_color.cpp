#include "color/apply_color.h"

#include <fmt/format.h>

#include <cmath>

namespace weft {
namespace {

constexpr float largest = 65504;  // of half

struct ColourChannels {
    int rgb[3] = {-1, -1, -1}, alpha = -1;
    bool grey = false;
};

ColourChannels colour_channels(const Image& image) {
    ColourChannels c;
    c.rgb[0] = image.find("R"), c.rgb[1] = image.find("G"), c.rgb[2] = image.find("B");
    c.alpha = image.find("A");
    if (c.rgb[0] >= 0 && c.rgb[1] >= 0 && c.rgb[2] >= 0) return c;
    const int grey = image.channels() == 1 ? 0 : image.find("Y");
    if (grey < 0)
        throw Error(fmt::format("a colour transform needs channels R G B or Y; this picture has {}",
                                fmt::join(image.names(), " ")));
    c.grey = true;
    c.rgb[0] = c.rgb[1] = c.rgb[2] = grey;
    return c;
}

// Gathers a row's colour without alpha; returns how many values were not finite.
size_t gather(const float* row, int width, int stride, const ColourChannels& c, float* rgb) {
    size_t bad = 0;
    for (int x = 0; x < width; ++x, row += stride, rgb += 3) {
        const float alpha = c.alpha >= 0 ? row[c.alpha] : 1.0f;
        const float scale = alpha > 0 && alpha < 1 ? 1 / alpha : 1.0f;
        for (int k = 0; k < 3; ++k) {
            float value = row[c.rgb[k]] * scale;
            if (!std::isfinite(value)) {
                value = std::isnan(value) ? 0.0f : std::copysign(largest, value);
                ++bad;
            }
            rgb[k] = value;
        }
    }
    return bad;
}

}  // namespace

Image apply_color(const Image& image, const ColorTransform& transform, Context& ctx) {
    const ColourChannels c = colour_channels(image);
    const int width = image.width(), stride = image.channels();
    // A grey picture stays one only if grey goes to grey: it is given the colours of a picture.
    Image out;
    if (c.grey) {
        out = Image(width, image.height(), c.alpha >= 0 ? 4 : 3);
        out.attributes = image.attributes;
    } else {
        out = image;
    }
    const int out_rgb[3] = {out.find("R"), out.find("G"), out.find("B")};
    const int out_alpha = out.find("A"), out_stride = out.channels();
    constexpr size_t grain = 16;  // rows
    const size_t bad = ctx.reduce<size_t>(
        size_t(image.height()), grain, 0,
        [&](size_t begin, size_t end) {
            std::vector<float> rgb(size_t(width) * 3 * (end - begin));
            size_t found = 0;
            for (size_t y = begin; y < end; ++y)
                found += gather(image.row(int(y)), width, stride, c,
                                rgb.data() + (y - begin) * size_t(width) * 3);
            transform.apply(rgb.data(), rgb.size() / 3);
            const float* from = rgb.data();
            for (size_t y = begin; y < end; ++y) {
                const float* in = image.row(int(y));
                float* to = out.row(int(y));
                for (int x = 0; x < width; ++x, from += 3, in += stride, to += out_stride) {
                    const float alpha = c.alpha >= 0 ? in[c.alpha] : 1.0f;
                    const float scale = alpha > 0 && alpha < 1 ? alpha : 1.0f;
                    for (int k = 0; k < 3; ++k) to[out_rgb[k]] = from[k] * scale;
                    if (out_alpha >= 0) to[out_alpha] = alpha;
                }
            }
            return found;
        },
        [](size_t a, size_t b) { return a + b; });
    if (bad)
        ctx.warn(fmt::format("{} values are NaN or infinite; taken as 0 and {}", bad, largest));
    out.color_space = transform.color_space;
    out.display = transform.display;
    out.view = transform.view;
    return out;
}

std::string space_of(const Image& image, const std::string& from, Context& ctx) {
    if (!from.empty()) return from;
    if (!image.color_space.empty()) return image.color_space;
    ctx.warn("the picture does not say what its values are; taken as lin_rec709");
    return "lin_rec709";
}

}  // namespace weft
