// Hierarchy: a sample buffer made ready for asking "which samples land here at (u, v, t)?".
// Samples are stored as seen from the lens centre at half time, sorted so that neighbours in the
// picture, in depth and in motion lie together; sixteen neighbours make a group, and a group has
// bounds that slide linearly over lens and shutter.
// Source: Lehtinen et al. 2011, Sec. 3.2 and Appendix A.  Departure: groups are runs of a sorted
// array and bounds are one mean slope and velocity with the largest deviation, not fitted planes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/large_array.h"
#include "samples/lens_shape.h"
#include "samples/samples.h"

namespace weft {

class Hierarchy {
  public:
    static constexpr size_t group_size = 16;
    static constexpr size_t fan_out = 16;

    int width = 0, height = 0;
    double mean_spp = 0;
    float radius = 2;  // px: the largest empty disk between samples that may be expected; "R" below
    std::vector<float>
        radii;             // px: R of each pixel, where the density of samples varies; else empty
    Lens lens;             // slopes; C0 = C1 = 0 for a pinhole buffer
    ShutterCurve shutter;  // how far open, over t
    bool moving = false;
    bool opaque = true;  // all alphas are 1
    std::string color_space = "lin_rec709";

    // One value a sample, sorted; the end is filled up to whole groups with samples that are
    // nowhere (W < 0). Position at lens centre and time t: (X + (t - 1/2) VX) / (W + (t - 1/2) VW),
    // y likewise; a sample is there while the divisor is above 0.
    LargeArray<float> X, Y, W;
    LargeArray<float> paths;  // W, VX, VY, VW, 4 a sample; empty where nothing moves
    LargeArray<float> rgba;   // 4 a sample: radiance, alpha
    // Where a light sees them, in the place of radiance: the change of 1/w a px of film
    // of each sample's surface (empty: not known), and its `end` and `bulge`
    // (shadows/passing_rays_kernel.h; empty: 0).
    LargeArray<float> plane_x, plane_y, end, bulge;
    LargeArray<std::uint32_t> order;  // index in the buffer
    Array<float> uv, t;  // the buffer's own, in its order: where and when each was seen
    Array<std::uint32_t> source;  // the same of what a light sees: the camera sample it was for

    // What a group's samples keep to: at (u, v, t), with d = t - 1/2 and s = slope,
    //   x in [x_low, x_high] + slope aspect u + velocity_x d,   y in [y_low, y_high] + slope v +
    //   velocity_y d.
    // The spreads say how far a member's own slope and velocity may be from the group's.
    struct Groups {
        LargeArray<float> slope, velocity_x, velocity_y;
        LargeArray<float> x_low, x_high, y_low, y_high;
        LargeArray<float> slope_spread, velocity_x_spread, velocity_y_spread;
        LargeArray<std::uint8_t> moves;  // 0: no member moves, 1: some do, 2: some in depth
        size_t size() const { return slope.size(); }
    } groups;

    // Rectangles over all lens positions and times: level 0 of the groups, each further level of
    // `fan_out` rectangles of the one before, up to a level of at most `fan_out`.
    struct Rects {
        LargeArray<float> x_low, x_high, y_low, y_high;
        size_t size() const { return x_low.size(); }
    };
    std::vector<Rects> levels;

    size_t size() const { return order.size(); }  // samples, without the filling

    // VX, VY, VW of a sample.
    struct Velocity {
        float x = 0, y = 0, w = 0;
    };
    Velocity velocity(size_t i) const {
        if (!moving) return {};
        const float* path = &paths[4 * i];
        return {path[1], path[2], path[3]};
    }
    size_t bytes() const;

    // Throws Error where samples have no radiance.
    void require_colors() const;

    // R at a place in the picture, and the largest in pixels [x0, x1) x [y0, y1); beyond the border
    // that of the nearest pixel.
    float radius_at(float x, float y) const;
    float largest_radius(int x0, int y0, int x1, int y1) const;

    // Appends, in ascending order, the groups that may be seen within [x0, x1] x [y0, y1] at any
    // (u, v, t).
    void collect(float x0, float y0, float x1, float y1, std::vector<std::uint32_t>& found) const;
};

WEFT_VALUE_TYPE(Hierarchy, "Hierarchy", "samples sorted for search over lens and shutter")

}  // namespace weft
