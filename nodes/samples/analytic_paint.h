// Outlines and textures of the garden: plain functions of a point on a patch or sphere.
// `paint` holds what one differs from the next by; the comment beside each says which number is
// what. Textures are sampled at a point, never filtered.
#pragma once
#include <algorithm>

#include "samples/analytic_geometry.h"

namespace weft::analytic {

// std::floor() of moderate numbers, without a call on machines that lack the instruction.
inline int floor_of(float x) {
    const int i = int(x);
    return i - int(x < float(i));
}
// Smooth noise in [0, 1), features one unit apart, the same on every machine.
float noise(float x, float y);
// 0 below edge0, 1 above edge1.
inline float smooth(float edge0, float edge1, float x) {
    const float s = std::clamp((x - edge0) / (edge1 - edge0), 0.0f, 1.0f);
    return s * s * (3 - 2 * s);
}

// ---- outlines: on the unit disk unless said otherwise; b = -1 is the root, b = 1 the tip ----
bool leaf_outline(const Paint&, float a, float b);
bool blade_outline(const Paint& paint, float a, float b);  // 0: bend, 1: width
bool blossom_outline(const Paint& paint, float a,
                     float b);  // 0: petals (5 or 8), 1: depth of the notches
bool petal_outline(const Paint& paint, float a, float b);  // 0: fullness of the tip
bool forewing_outline(const Paint&, float a, float b);  // square; a = -1 at the body, b = 1 ahead
bool hindwing_outline(const Paint&, float a, float b);  // square
bool hills_outline(const Paint& paint, float a,
                   float b);  // square; 0: hills across, 1: roughness, 2: phase
bool ring_outline(const Paint& paint, float a, float b);  // 0: inner radius

// ---- textures ----
Surface plain(const Paint& paint, float a, float b, Vec3 n);  // color 0
Surface leaf_texture(const Paint& paint, float a, float b,
                     Vec3 n);  // color 0 blade, 1 veins; 0: phase
Surface blade_texture(const Paint& paint, float a, float b, Vec3 n);  // color 0 root, 1 tip
Surface blossom_texture(const Paint& paint, float a, float b,
                        Vec3 n);  // color 0 rim, 1 throat, 2 stamens; 0: petals
Surface petal_texture(const Paint& paint, float a, float b, Vec3 n);  // color 0 tip, 1 root
Surface stamens_texture(const Paint& paint, float a, float b,
                        Vec3 n);  // color 0, 1: two kinds of floret
Surface forewing_texture(const Paint& paint, float a, float b,
                         Vec3 n);  // color 0 inner, 1 outer, 2 margin, 3 spots
Surface hindwing_texture(const Paint& paint, float a, float b, Vec3 n);  // the same
Surface glow_texture(const Paint& paint, float a, float b, Vec3 n);      // color 0: radiance
Surface lantern_texture(const Paint& paint, float a, float b,
                        Vec3 n);  // color 0: radiance; 0: ribs
Surface ball_texture(const Paint& paint, float a, float b,
                     Vec3 n);  // color 0 glaze, 1 pattern; 0: pattern, 1: turn
Surface hills_texture(const Paint& paint, float a, float b, Vec3 n);  // color 0 crest, 1 foot

}  // namespace weft::analytic
