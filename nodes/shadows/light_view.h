// LightView: a light that looks at the receivers of a sample buffer as a camera with a lens would:
// the light's area is the lens, a plane in front of it the film.
//   light space   X along the light's ex, Y along ey, w the distance in front of its plane (> 0)
//   l             where on the light: (ax l.x, ay l.y, 0) in light space; a quad is [-1, 1]^2, a
//                 disc the unit disc; of a ball, which looks from each receiver like another disc,
//                 and of a mesh, where the ray crosses the plane through its middle
//   q             px of the film: c + k (X, Y) / w + (C0 / w + C1) l with C0 = -k a, C1 = k a / F;
//                 the focus distance F moves samples over the film, not the result
//   time          what moves goes straight in light space between both ends of the shutter; so a
//                 moving light is motion of all else
// Source: Lehtinen et al. 2011, Sec. 4 (a light as a camera); the two-plane form with C0 and C1 is
// that of the camera's own lens (docs/formats.md).
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/value.h"
#include "samples/samples.h"
#include "samples/vec3.h"

namespace weft {

// Double precision: shadows are told by differences of depths.
struct Point3 {
    double x = 0, y = 0, z = 0;
    friend Point3 operator+(Point3 a, Point3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Point3 operator-(Point3 a, Point3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Point3 operator*(Point3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
};
inline double dot(Point3 a, Point3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Point3 cross(Point3 a, Point3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Point3 to_double(Vec3 v) {
    return {double(v.x), double(v.y), double(v.z)};
}
inline Vec3 to_float(Point3 p) {
    return {float(p.x), float(p.y), float(p.z)};
}

// p -> x p.x + y p.y + z p.z + origin.
struct Map3 {
    Point3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin{};
    Point3 vector(Point3 v) const { return x * v.x + y * v.y + z * v.z; }
    Point3 point(Point3 p) const { return vector(p) + origin; }
    friend Map3 operator*(const Map3& a, const Map3& b) {
        return {a.vector(b.x), a.vector(b.y), a.vector(b.z), a.point(b.origin)};
    }
};
Map3 inverse(const Map3& m);

// A triangle of a mesh that shines, in light space.
struct LightTriangle {
    Point3 a, b, c;
    double end = 1;  // the part of the light that it and all triangles before it send out
};

// Where a ray starts: on the light's plane at l, or at a mesh's depth w before it or behind it.
struct LightPoint {
    double lx = 0, ly = 0, depth = 0;
};

class LightView {
  public:
    enum class Shape { quad, disc, sphere, point, mesh };

    std::string name;
    std::uint32_t light = 0;  // its place in meta.lights: the `light_index` of samples
    Shape shape = Shape::quad;
    double ax = 1, ay = 1;  // half extents of l = 1, world units; 0: a point
    double radius = 0;      // of a ball, or of a mesh that is not flat
    std::vector<LightTriangle> triangles;  // of a mesh
    bool flat = true;                      // all of them lie in the light's plane
    bool two_sided = false;                // they shine to both sides
    double k = 1, cx = 0, cy = 0, focus = 1;
    double nearest = 1e-3;      // w: what is nearer to the light's plane is not seen
    int width = 0, height = 0;  // of the film, px
    double spp = 1;             // of the camera's samples: how dense light samples are where a
                                // pixel of the one film is as large as one of the other
    // At the opening and at the close of the shutter.
    std::array<Map3, 2> world_to_light, light_to_world;
    std::array<Map3, 2> pixel_to_world;  // (x z, y z, z) of a camera sample, x and y in px

    bool moves = false;  // the light does, so still things move in its view

    double c0x() const { return -k * ax; }
    double c0y() const { return -k * ay; }
    double c1x() const { return k * ax / focus; }
    double c1y() const { return k * ay / focus; }
    Lens lens() const;  // as samples and hierarchies have it

    // A point in light space, given where it is in the world at time t.
    Point3 from_world(Point3 world, double t) const {
        const Point3 open = world_to_light[0].point(world), close = world_to_light[1].point(world);
        return open + (close - open) * t;
    }
    Point3 to_world(Point3 in_light_space, double t) const;
    // A camera sample at time t, given its homogeneous position (x z, y z, z) at both ends.
    Point3 from_camera(Point3 open, Point3 close, double t) const {
        const Point3 a = world_to_light[0].point(pixel_to_world[0].point(open)),
                     b = world_to_light[1].point(pixel_to_world[1].point(close));
        return a + (b - a) * t;
    }

    // Where a point in light space, w > 0, lies on the film seen from l.
    std::array<double, 2> project(Point3 p, double lx, double ly) const {
        const double inverse = 1 / p.z;
        return {cx + k * p.x * inverse + (c0x() * inverse + c1x()) * lx,
                cy + k * p.y * inverse + (c0y() * inverse + c1y()) * ly};
    }
    // Change of 1/w a px of film, seen from l = 0, of the plane through p with this normal; 0 where
    // the plane is seen edge-on.
    std::array<double, 2> inverse_depth_gradient(Point3 p, Point3 normal) const;
    // The light's point of two numbers in [0, 1), evenly spread over it (a ball, a mesh that is not
    // flat: over what of it a receiver in light space sees).
    LightPoint draw(double a, double b, Point3 receiver) const;
    std::array<double, 2> point(double a, double b, Point3 receiver) const {
        const LightPoint at = draw(a, b, receiver);
        return {at.lx, at.ly};
    }
    // A point of the light in light space, as the receiver sees it.
    LightPoint seen_through(Point3 at, Point3 receiver) const;
    // Where the ray to a receiver starts, in light space.
    Point3 start(const LightPoint& at, Point3 receiver) const {
        const Point3 on_plane{ax * at.lx, ay * at.ly, 0};
        return on_plane + (receiver - on_plane) * (at.depth / receiver.z);
    }
    // Whether it shines on what lies behind its plane, too, where a view does not look.
    bool shines_behind() const {
        return shape == Shape::sphere || shape == Shape::point || two_sided || !flat;
    }
    bool same_points() const { return shape != Shape::sphere && flat; }  // for all receivers

    size_t bytes() const { return sizeof(LightView) + triangles.size() * sizeof(LightTriangle); }

  private:
    LightPoint on_ball(double a, double b, Point3 receiver) const;
    LightPoint on_mesh(double a, double b, Point3 receiver) const;
};

WEFT_VALUE_TYPE(LightView, "LightView", "a light that looks at the receivers of a sample buffer")

}  // namespace weft
