#include "samples/analytic_known.h"

#include <algorithm>
#include <numbers>

namespace weft::analytic {
namespace {

constexpr double pi = std::numbers::pi;
constexpr float focus = 4;

// One unit at depth 1 is as wide as the picture is high.
Camera camera_of(const AnalyticOptions& o, float lens_radius) {
    return {.scale = float(o.height),
            .center_x = 0.5f * float(o.width),
            .center_y = 0.5f * float(o.height),
            .lens_radius = lens_radius * o.aperture,
            .focus = focus};
}

Vec3 black(float, float) {
    return {};
}

Surface flat(const Paint& paint, float, float, Vec3) {
    return {paint.color[0], paint.color[0]};
}

// A square wall at depth z, `extent` units to every side of (x, y).
Primitive wall(float x, float y, float z, float extent, Texture texture, Vec3 color = {}) {
    Primitive p;
    p.origin = {x, y, z};
    p.side_a = {extent, 0, 0};
    p.side_b = {0, extent, 0};
    p.square = true;
    p.texture = texture;
    p.paint.color[0] = color;
    return p;
}

// ---- step -------------------------------------------------------------------------------------

constexpr Vec3 bright{0.9f, 0.6f, 0.3f}, dark{0.05f, 0.1f, 0.2f};
constexpr float step_edge = 0.03f,
                step_speed = 0.5f;  // units at the depth in focus, units a shutter

double step_blend(double covered, float front, float back) {
    return covered * double(front) + (1 - covered) * double(back);
}

// ---- plane ------------------------------------------------------------------------------------

// Colour k of the texture is 0.5 + 0.4 sin(fx X + k) sin(fy Y + 2 k), X and Y in units.
constexpr double wave_x[3] = {2 * pi / 0.41, 2 * pi / 0.67, 2 * pi / 1.3};
constexpr double wave_y[3] = {2 * pi / 0.53, 2 * pi / 0.83, 2 * pi / 0.29};
constexpr float wall_extent = 32;

Surface waves(const Paint&, float a, float b, Vec3) {
    const double x = double(a) * wall_extent, y = double(b) * wall_extent;
    float c[3];
    for (int k = 0; k < 3; ++k)
        c[k] = float(0.5 + 0.4 * std::sin(wave_x[k] * x + k) * std::sin(wave_y[k] * y + 2 * k));
    return {{c[0], c[1], c[2]}, {c[0], c[1], c[2]}};
}

// Mean of sin(w s + phase) for s in [s0, s1].
double mean_sine(double w, double phase, double s0, double s1) {
    return (std::cos(w * s0 + phase) - std::cos(w * s1 + phase)) / (w * (s1 - s0));
}

// ---- disc -------------------------------------------------------------------------------------

constexpr Vec3 glow{8, 6, 4};
constexpr float disc_radius = 0.25f, disc_depth = 12;

// ---- layers -----------------------------------------------------------------------------------

constexpr float front_edge = 0.02f, front_depth = 2;

}  // namespace

double disk_below(double h) {
    h = std::clamp(h, -1.0, 1.0);
    return 0.5 + (h * std::sqrt(1 - h * h) + std::asin(h)) / pi;
}

double common_area(double a, double b, double d) {
    if (d >= a + b) return 0;
    if (d <= std::fabs(a - b)) return pi * std::min(a, b) * std::min(a, b);
    const double x = (d * d + a * a - b * b) / (2 * d),
                 y = d - x;  // of the chord, from each centre
    const auto segment = [](double r, double s) {
        return r * r * std::acos(std::clamp(s / r, -1.0, 1.0)) -
               s * std::sqrt(std::max(r * r - s * s, 0.0));
    };
    return segment(a, x) + segment(b, y);
}

Scene step_scene(const AnalyticOptions& o) {
    Scene scene{camera_of(o, 0.1f), black, {}};
    Primitive front = wall(step_edge - wall_extent, 0, focus, wall_extent, flat, bright);
    front.origin_motion = {step_speed * o.shutter, 0, 0};
    scene.primitives = {front, wall(0, 0, 2 * focus, 4 * wall_extent, flat, dark)};
    return scene;
}

Color step_exact(const AnalyticOptions& o, int x, int) {
    const double per_unit = o.height / double(focus),
                 middle = 0.5 * o.width + per_unit * double(step_edge);
    const double travel = per_unit * double(step_speed) * double(o.shutter);
    const double e0 = middle - travel / 2 - x, e1 = middle + travel / 2 - x;
    // The integral of clamp(s, 0, 1).
    const auto swept = [](double s) { return s <= 0 ? 0.0 : s >= 1 ? s - 0.5 : s * s / 2; };
    const double covered =
        travel == 0 ? std::clamp(e0, 0.0, 1.0) : (swept(e1) - swept(e0)) / travel;
    return {step_blend(covered, bright.x, dark.x), step_blend(covered, bright.y, dark.y),
            step_blend(covered, bright.z, dark.z)};
}

Scene plane_scene(const AnalyticOptions& o) {
    return {camera_of(o, 0.1f), black, {wall(0, 0, focus, wall_extent, waves)}};
}

Color plane_exact(const AnalyticOptions& o, int x, int y) {
    const double unit_px = double(focus) / o.height;
    const double x0 = (x - 0.5 * o.width) * unit_px, y0 = (y - 0.5 * o.height) * unit_px;
    Color c;
    for (int k = 0; k < 3; ++k)
        c[size_t(k)] = 0.5 + 0.4 * mean_sine(wave_x[k], k, x0, x0 + unit_px) *
                                 mean_sine(wave_y[k], 2 * k, y0, y0 + unit_px);
    return c;
}

Scene disc_scene(const AnalyticOptions& o) {
    Primitive light;
    light.origin = {0, 0, disc_depth};
    light.side_a = {disc_radius, 0, 0};
    light.side_b = {0, disc_radius, 0};
    light.texture = flat;
    light.paint.color[0] = glow;
    return {camera_of(o, 0.4f), black, {light}};
}

// At a point the light fills that share of the lens that its picture, `light` pixels wide, fills of
// the blur about the point.
Color disc_exact(const AnalyticOptions& o, int x, int y) {
    const Lens lens = camera_of(o, 0.4f).lens();
    const double light = o.height * double(disc_radius) / double(disc_depth);
    const double blur = std::fabs(double(lens.c0) / double(disc_depth) + double(lens.c1));
    constexpr int n = 64;
    double share = 0;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const double d =
                std::hypot(x + (i + 0.5) / n - 0.5 * o.width, y + (j + 0.5) / n - 0.5 * o.height);
            share +=
                blur > 0 ? common_area(light, blur, d) / (pi * blur * blur) : double(d < light);
        }
    share /= n * n;
    return {share * double(glow.x), share * double(glow.y), share * double(glow.z)};
}

Scene layers_scene(const AnalyticOptions& o) {
    Scene scene = plane_scene(o);
    scene.camera = camera_of(o, 0.2f);
    scene.primitives.insert(scene.primitives.begin(), wall(front_edge - wall_extent, 0, front_depth,
                                                           wall_extent, flat, bright));
    return scene;
}

// The front hides what is left of its edge as seen from each lens position: a segment of the disk.
Color layers_exact(const AnalyticOptions& o, int x, int y) {
    const Lens lens = camera_of(o, 0.2f).lens();
    const double edge = 0.5 * o.width + o.height * double(front_edge) / double(front_depth);
    const double blur = -(double(lens.c0) / double(front_depth) + double(lens.c1));
    const double unit_px = double(focus) / o.height, y0 = (y - 0.5 * o.height) * unit_px;
    const float front[3] = {bright.x, bright.y, bright.z};
    constexpr int n = 256;
    Color c{};
    for (int i = 0; i < n; ++i) {
        const double px = x + (i + 0.5) / n, world = (px - 0.5 * o.width) * unit_px;
        const double hidden = blur > 0 ? disk_below((edge - px) / blur) : double(px < edge);
        for (int k = 0; k < 3; ++k) {
            const double back = 0.5 + 0.4 * std::sin(wave_x[k] * world + k) *
                                          mean_sine(wave_y[k], 2 * k, y0, y0 + unit_px);
            c[size_t(k)] += (hidden * double(front[k]) + (1 - hidden) * back) / n;
        }
    }
    return c;
}

}  // namespace weft::analytic
