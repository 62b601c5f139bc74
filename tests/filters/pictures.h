// Small pictures for tests of filters.
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "image/image.h"
#include "samples/random.h"

namespace weft {

inline float random_at(size_t i, size_t what) {
    return unit_float(mix(i * 97 + what * 1000003));
}
inline float normal_at(size_t i, size_t what) {
    return std::sqrt(-2 * std::log(1 - random_at(i, what))) *
           std::cos(6.2831853f * random_at(i, what + 500));
}

// of(x, y, channel) for every value.
template <class Of>
Image make_picture(int width, int height, std::vector<std::string> names, Of&& of) {
    Image image(width, height, std::move(names));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < image.channels(); ++c) image.at(x, y)[c] = of(x, y, c);
    return image;
}
inline Image random_picture(int width, int height, std::vector<std::string> names, size_t seed,
                            float scale = 1) {
    return make_picture(width, height, std::move(names), [&](int x, int y, int c) {
        return scale * random_at(size_t((y * 4096 + x) * 32 + c), seed);
    });
}
inline Image mirrored(const Image& image) {
    return make_picture(image.width(), image.height(), image.names(),
                        [&](int x, int y, int c) { return image.at(image.width() - 1 - x, y)[c]; });
}

}  // namespace weft
