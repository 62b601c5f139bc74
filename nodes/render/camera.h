// Camera: a thin lens that may move, as samples describe it.
//   camera space   x right, y down, z forward (a scene's camera looks along its own -z, y up)
//   film           pixels, y down; a point at camera (x, y, z) is seen from the lens centre at
//                  (scale x / z + center_x, scale y / z + center_y)
//   lens           (u, v) in the unit disk is the point (aspect R u, R v) of it; the circle of
//                  confusion is c(z) = C0 / z + C1 with C0 = -scale R, C1 = scale R / focus
#pragma once
#include "graph/json.h"
#include "render/keyed_motion.h"
#include "samples/lens_shape.h"

namespace weft::render {

class Camera {
  public:
    Camera(const SceneCamera& camera, int width, int height);

    struct Ray {
        Vec3 origin, direction;  // world; unit
    };
    Ray ray(float film_x, float film_y, float u, float v, float time) const;
    // From the lens centre, not unit: depth 1 along the axis.
    Vec3 to_camera(Vec3 world, float time) const;
    Vec3 direction_to_camera(Vec3 world, float time) const;
    // (x z, y z, z) of a camera-space point, x and y in pixels, seen from the lens centre.
    Vec3 homogeneous(Vec3 camera) const {
        return {scale_ * camera.x + center_x_ * camera.z, scale_ * camera.y + center_y_ * camera.z,
                camera.z};
    }
    // Change of depth a pixel of film in x and y, of the plane through `at` with `normal`, both in
    // world space, seen through lens point (u, v) at a time.
    Vec2 depth_gradient(float film_x, float film_y, float u, float v, float time, Vec3 at,
                        Vec3 normal) const;

    Lens lens() const { return lens_; }
    bool pinhole() const { return radius_ == 0; }
    const ShutterCurve& shutter() const { return shutter_; }
    // Angle of a pixel, about: how a ray's footprint grows with distance.
    float pixel_spread() const { return 1 / scale_; }
    bool moving() const { return motion_.moving(); }

    // What `meta.camera` says: world_to_camera at the shutter's opening (and at its end where it
    // moves), camera_to_pixel.
    Json meta() const;

  private:
    Affine at(float time) const { return moving() ? motion_.at(time) : still_; }
    Affine from(float time) const { return moving() ? inverse(motion_.at(time)) : still_inverse_; }

    KeyedMotion motion_;
    Affine still_, still_inverse_;
    float scale_, center_x_, center_y_, radius_, focus_, aspect_;
    Lens lens_;
    ShutterCurve shutter_;
};

}  // namespace weft::render
