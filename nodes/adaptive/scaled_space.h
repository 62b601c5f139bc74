// Scaled space: the axes of a buffer's samples in pixels, so that distances along them compare. x
// and y are the film's; any other axis is as long as the picture moves over it. Lens positions lie
// in the disk, from -1 to 1 along the axis: as samples and locations have them.
#pragma once
#include <string>
#include <vector>

#include "adaptive/leaf_tree.h"
#include "light-field/streams.h"
#include "samples/samples.h"

namespace weft::adaptive {

inline constexpr float usual_extent = 16;  // px, at most, of an axis of which nothing is known

// Gives axes behind x and y of which nothing is known (0 px) a length: so short that the box of
// equal sides that a sample stands for is hardly wider than a pixel, if so many samples a pixel
// allow it. Over more axes, or longer ones, what is nearest to a place would lie beside it on the
// film.
void shorten_axes(std::vector<float>& extent, double samples_a_pixel);

struct ScaledSpace {
    std::vector<std::string> axes;  // x, y first
    std::vector<float> extent;      // px
};

// Of the leaves, or of what a buffer has: uv, t, light_uv; each as long as samples say (motion; z
// and lens), `usual_extent` where they do not.
ScaledSpace space_of(const LeafTree& leaves);
ScaledSpace space_of(const Samples& samples);

// Medians over the samples: |velocity| in px per shutter; twice the |circle of confusion| in px. 0
// where the buffer does not say.
float median_motion(const Samples& samples);
float median_defocus(const Samples& samples);

// Where samples lie, axes x n. Throws Error where the buffer lacks an axis.
std::vector<std::vector<float>> places_in(const ScaledSpace& space, const Samples& samples,
                                          std::string_view who);

// Number of a location along an axis that is neither x nor y, px.
float place_of(const ScaledSpace& space, size_t axis, const Locations& at, size_t location);

}  // namespace weft::adaptive
