// What a node on pictures needs, said before it runs: for plans and --memory.
#pragma once
#include "runtime/node.h"

namespace weft {

inline Shape image_shape(std::int64_t width, std::int64_t height, std::int64_t channels) {
    return {width, height, channels, 0, 4.0 * double(width) * double(height) * double(channels)};
}

// One picture out of the size of the one at `input`, with its channels (0) or so many; floats of
// scratch and operations a pixel.
inline Cost cost_like(const Shapes& in, std::string_view input, const std::string& output,
                      std::int64_t channels = 0, double scratch_floats = 0,
                      double operations = 10) {
    const Shape from = in[input];
    const double pixels = double(from.width) * double(from.height);
    return {
        {{output, image_shape(from.width, from.height, channels > 0 ? channels : from.channels)}},
        4 * scratch_floats * pixels,
        operations * pixels};
}

}  // namespace weft
