#include "render/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>

#include "graph/error.h"

namespace weft::render {
namespace {

Vec3 flipped(Vec3 v) {
    return {v.x, -v.y, -v.z};
}

Json numbers(std::initializer_list<float> values) {
    Json list = Json::list();
    for (const float value : values) list.items.emplace_back(double(value));
    return list;
}

Json world_to_camera(const Affine& to_world) {
    const Affine m = inverse(to_world);
    Json rows = Json::list();
    rows.items.push_back(numbers({m.x.x, m.y.x, m.z.x, m.origin.x}));
    rows.items.push_back(numbers({-m.x.y, -m.y.y, -m.z.y, -m.origin.y}));
    rows.items.push_back(numbers({-m.x.z, -m.y.z, -m.z.z, -m.origin.z}));
    rows.items.push_back(numbers({0, 0, 0, 1}));
    return rows;
}

}  // namespace

Camera::Camera(const SceneCamera& c, int width, int height) {
    const auto fail = [&](const std::string& what) {
        throw Error(fmt::format("camera '{}': {}", c.name, what));
    };
    if (c.to_world.empty() ||
        !std::all_of(c.to_world.begin(), c.to_world.end(),
                     [](const Affine& m) { return finite(m) && is_invertible(m); }))
        fail("its transform is not finite, or has no inverse");
    if (!(c.vertical_fov > 0 && c.vertical_fov < 3.14f))
        fail(fmt::format("its field of view is {} radians; expected above 0, below pi",
                         c.vertical_fov));
    if (!(c.lens_radius >= 0) || !std::isfinite(c.lens_radius))
        fail(fmt::format("its lens radius is {}; expected 0 or more", c.lens_radius));
    if (!(c.focus > 0) || !std::isfinite(c.focus))
        fail(fmt::format("its focus distance is {}; expected above 0", c.focus));
    if (!(c.lens_aspect > 0) || !std::isfinite(c.lens_aspect))
        fail(fmt::format("its lens aspect is {}; expected above 0", c.lens_aspect));
    motion_ = KeyedMotion(c.to_world);
    still_ = motion_.matrices()[0];
    still_inverse_ = inverse(still_);
    scale_ = 0.5f * float(height) / std::tan(0.5f * c.vertical_fov);
    center_x_ = 0.5f * float(width);
    center_y_ = 0.5f * float(height);
    radius_ = c.lens_radius;
    focus_ = c.focus;
    aspect_ = c.lens_aspect;
    if (radius_ > 0)
        lens_ = {-scale_ * radius_, scale_ * radius_ / focus_, aspect_, c.blades, c.blade_rotation};
    shutter_ = ShutterCurve(c.shutter_curve);
}

Camera::Ray Camera::ray(float film_x, float film_y, float u, float v, float time) const {
    const Vec3 lens{aspect_ * radius_ * u, radius_ * v, 0};
    const Vec3 focused{(film_x - center_x_) * (focus_ / scale_),
                       (film_y - center_y_) * (focus_ / scale_), focus_};
    const Affine to_world = at(time);
    return {to_world.point(flipped(lens)), unit(to_world.vector(flipped(focused - lens)))};
}

Vec3 Camera::to_camera(Vec3 world, float time) const {
    return flipped(from(time).point(world));
}
Vec3 Camera::direction_to_camera(Vec3 world, float time) const {
    return flipped(from(time).vector(world));
}

Vec2 Camera::depth_gradient(float film_x, float film_y, float u, float v, float time, Vec3 at_world,
                            Vec3 normal_world) const {
    // The ray is lens + s d with d.z = focus, so depth is s focus; on the plane s = n.(p - lens) /
    // n.d, and a pixel of film moves d by focus / scale.
    const Vec3 p = to_camera(at_world, time);
    const Vec3 n = flipped(transformed_normal(from(time), normal_world));
    const Vec3 lens{aspect_ * radius_ * u, radius_ * v, 0};
    const float step = focus_ / scale_;
    const Vec3 d = Vec3{(film_x - center_x_) * step, (film_y - center_y_) * step, focus_} - lens;
    const float nd = dot(n, d);
    if (nd == 0) return {};
    const float s = dot(n, p - lens) / nd, g = -s / nd * step * focus_;
    return {g * n.x, g * n.y};
}

Json Camera::meta() const {
    Json camera = Json::object();
    camera.set("world_to_camera", world_to_camera(motion_.matrices().front()));
    if (moving()) camera.set("world_to_camera_end", world_to_camera(motion_.matrices().back()));
    Json rows = Json::list();
    rows.items.push_back(numbers({scale_, 0, center_x_}));
    rows.items.push_back(numbers({0, scale_, center_y_}));
    rows.items.push_back(numbers({0, 0, 1}));
    camera.set("camera_to_pixel", std::move(rows));
    return camera;
}

}  // namespace weft::render
