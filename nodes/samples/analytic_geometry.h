// What analytic scenes are made of: flat patches and spheres on straight paths, and a thin lens.
// Rays leave the lens at (R u, R v, 0) and pass the film position's point of the plane in focus.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "samples/samples.h"
#include "samples/vec3.h"

namespace weft::analytic {

// Colours and numbers that a texture goes by.
struct Paint {
    std::array<Vec3, 4> color{};
    std::array<float, 6> number{};
    Vec3 light{1, 1, 1};  // that falls on it, baked
};
// What a texture says of a point. `radiance` leaves it in every direction, at every time.
struct Surface {
    Vec3 albedo, radiance;
};
// A patch's point is (a, b), each in [-1, 1]; of a sphere (a, b) are x and y of the normal and `n`
// is all of it.
using Outline = bool (*)(const Paint& paint, float a, float b);  // null: all of the disk or square
using Texture = Surface (*)(const Paint& paint, float a, float b, Vec3 n);

// A patch's point at time t is origin + a side_a + b side_b + (t - 1/2) (the same of the
// `_motion`s). A sphere is one with a radius; its sides are not looked at.
struct Primitive {
    Vec3 origin, side_a, side_b;
    Vec3 origin_motion, side_a_motion, side_b_motion;
    float radius = 0;     // > 0: a sphere
    bool square = false;  // the patch is |a|, |b| <= 1 instead of a^2 + b^2 <= 1
    Outline outline = nullptr;
    Texture texture = nullptr;
    Paint paint;

    bool sphere() const { return radius > 0; }
    bool turns() const { return !(side_a_motion == Vec3{} && side_b_motion == Vec3{}); }
    Vec3 point(float a, float b, float t) const {
        const float s = t - 0.5f;
        return origin + s * origin_motion + a * (side_a + s * side_a_motion) +
               b * (side_b + s * side_b_motion);
    }
    // Of the point (a, b) of a patch, of any point of a sphere: displacement over the shutter.
    Vec3 displacement(float a, float b) const {
        return sphere() ? origin_motion : origin_motion + a * side_a_motion + b * side_b_motion;
    }
};

// A camera at the origin that looks along z. Pixels are square; the principal point may lie off the
// middle.
struct Camera {
    float scale = 0;                   // pixels a unit of x / z
    float center_x = 0, center_y = 0;  // principal point, pixels
    float lens_radius = 0, focus = 1;

    // Coefficients of the circle of confusion (samples.h).
    Lens lens() const { return {.c0 = -scale * lens_radius, .c1 = scale * lens_radius / focus}; }
};

// Radiance of what is infinitely far, by x / z and y / z of its direction.
using Sky = Vec3 (*)(float x, float y);

struct Scene {
    Camera camera;
    Sky sky = nullptr;
    std::vector<Primitive> primitives;
};

// Rays of a batch, struct of arrays, and what they hit.
struct Rays {
    static constexpr int capacity = 1024;
    int count = 0;
    alignas(64) float lens_x[capacity], lens_y[capacity];  // scene units
    alignas(64) float x[capacity], y[capacity];            // direction, z = 1
    alignas(64) float time[capacity];                      // t - 1/2
    alignas(64) float depth[capacity];                     // +inf: nothing
    alignas(64) std::int32_t hit[capacity];                // primitive, or -1
    alignas(64) float a[capacity], b[capacity];
};

// A scene made ready for rays: what can be seen in each tile of a picture, near to far.
class Tracer {
  public:
    static constexpr int tile = 8;  // pixels

    Tracer(const Scene& scene, int width, int height);
    // Finds what the rays of a tile hit; fills depth, hit, a, b.
    void trace(int tile_x, int tile_y, Rays& rays) const;
    // The same without tiles or early outs: what trace() is held to.
    void trace_all(Rays& rays) const;

    const Scene& scene() const { return scene_; }
    int tiles_x() const { return tiles_x_; }
    int tiles_y() const { return tiles_y_; }

  private:
    const Scene& scene_;
    int tiles_x_, tiles_y_;
    std::vector<float> nearest_;  // smallest depth of each primitive over the shutter
    std::vector<std::uint32_t> first_,
        list_;  // primitives of tile i: list_[first_[i] .. first_[i + 1])
};

}  // namespace weft::analytic
