#include "shadows/fit_light_view_kernel.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "graph/error.h"
#include "shadows/camera_samples.h"
#include "shadows/light_mesh.h"

namespace weft::shadows {
namespace {

constexpr double widest_film = 32000;  // px: as much as sorting tells apart (build-hierarchy)

[[noreturn]] void fail(const std::string& message) {
    throw Error("samples: meta: " + message);
}

std::vector<double> numbers(const Json* list, size_t count, const std::string& what) {
    std::vector<double> out;
    if (list && list->is(Json::Kind::list))
        for (const Json& item : list->items)
            if (item.is(Json::Kind::number) && std::isfinite(item.number))
                out.push_back(item.number);
    if (out.size() != count || out.size() != list->items.size())
        fail(fmt::format("{} is {}; expected {} numbers", what, list ? list->dump() : "not there",
                         count));
    return out;
}
Point3 point_of(const Json& object, std::string_view key, const std::string& what) {
    const auto v = numbers(object.find(key), 3, fmt::format("'{}' of {}", key, what));
    return {v[0], v[1], v[2]};
}

Point3 unit(Point3 a) {
    return a * (1 / std::sqrt(dot(a, a)));
}

struct FoundLight {
    const Json* json;
    std::uint32_t index;
    std::string name, shape;
};

FoundLight find_light(const Samples& samples, const std::string& wanted) {
    const Json* lights = samples.meta.find("lights");
    std::vector<std::string> names;
    FoundLight first{nullptr, 0, "", ""}, numbered = first;
    bool first_has_area = false;
    for (size_t i = 0; lights && lights->is(Json::Kind::list) && i < lights->items.size(); ++i) {
        const Json& one = lights->items[i];
        const auto text = [&](std::string_view key) {
            const Json* value = one.find(key);
            return value && value->is(Json::Kind::text) ? value->text : std::string();
        };
        FoundLight light{&one, std::uint32_t(i), text("name"), text("shape")};
        names.push_back(light.name);
        const bool area = light.shape == "quad" || light.shape == "disc" ||
                          light.shape == "sphere" || light.shape == "mesh";
        if (!wanted.empty() && light.name == wanted) return light;
        if (wanted == std::to_string(i)) numbered = light;
        if (light.shape == "directional" || (first.json && (first_has_area || !area))) continue;
        first = light;
        first_has_area = area;
    }
    if (names.empty())
        fail(
            "no 'lights': shadows need a light; give the scene one, or name it in the file's meta");
    if (numbered.json) return numbered;
    if (!wanted.empty())
        fail(fmt::format("no light '{}'; there are '{}'", wanted, fmt::join(names, "', '")));
    if (!first.json) fail("its lights are directional only; expected one at a distance");
    return first;
}

// Where l = (1, 0), (0, 1) and the way in front are, at one end of the shutter.
Map3 light_frame(const FoundLight& light, const std::string& end, Point3 towards) {
    const std::string what = fmt::format("light '{}'", light.name);
    const Point3 origin = point_of(*light.json, "origin" + end, what);
    if (light.shape == "sphere" || light.shape == "point" || light.shape == "spot") {
        Point3 ahead = towards - origin;
        ahead = dot(ahead, ahead) > 0 ? unit(ahead) : Point3{0, 0, 1};
        const Point3 aside = std::abs(ahead.x) < 0.7 ? Point3{1, 0, 0} : Point3{0, 1, 0};
        const Point3 x = unit(cross(aside, ahead));
        return {x, cross(ahead, x), ahead, origin};
    }
    const Point3 ex = point_of(*light.json, "ex" + end, what),
                 ey = point_of(*light.json, "ey" + end, what);
    const Point3 back = cross(ex, ey);
    if (!(dot(back, back) > 1e-12 * dot(ex, ex) * dot(ey, ey)))
        fail(fmt::format("'ex' and 'ey' of {} span no plane", what));
    return {unit(ex), unit(ey), unit(back) * -1.0, origin};
}

// The triangles of a light that is a mesh, as render-samples writes them.
WorldMesh world_mesh(const FoundLight& light) {
    const std::string what = fmt::format("light '{}'", light.name);
    const auto triangles = [&](const Json* list, std::string_view key) {
        std::vector<WorldMesh::Corners> out;
        for (const Json& one : list->items) {
            const auto v = numbers(&one, 9, fmt::format("one of '{}' of {}", key, what));
            out.push_back({Point3{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}});
        }
        return out;
    };
    const Json* open = light.json->find("triangles");
    if (!open || !open->is(Json::Kind::list) || open->items.empty())
        fail(
            fmt::format("{} is a mesh without 'triangles': expected 9 numbers of each; "
                        "render-samples writes up to 4096",
                        what));
    WorldMesh mesh;
    mesh.open = triangles(open, "triangles");
    const size_t n = mesh.open.size();
    if (const Json* close = light.json->find("triangles_end");
        close && close->is(Json::Kind::list)) {
        mesh.close = triangles(close, "triangles_end");
        if (mesh.close.size() != n)
            fail(fmt::format("'triangles_end' of {} are {}; expected as many as 'triangles', {}",
                             what, mesh.close.size(), n));
    }
    if (const Json* chances = light.json->find("chances"))
        mesh.chances = numbers(chances, n, fmt::format("'chances' of {}", what));
    const Json* sides = light.json->find("two_sided");
    mesh.two_sided = sides && sides->is(Json::Kind::boolean) && sides->boolean;
    return mesh;
}

Map3 pixel_to_world(const Samples& samples, const std::string& end) {
    const Json* camera = samples.meta.find("camera");
    const std::string key = "world_to_camera" + end;
    if (!camera || !camera->find(key) || !camera->find("camera_to_pixel"))
        fail(
            "no 'camera' with world_to_camera and camera_to_pixel: where samples lie in the world "
            "is not known; render-samples writes it (docs/formats.md)");
    const auto rows = [&](std::string_view name, size_t count, size_t width) {
        const Json* list = camera->find(name);
        std::vector<double> out;
        for (size_t r = 0; r < count; ++r) {
            const Json* row =
                list->is(Json::Kind::list) && r < list->items.size() ? &list->items[r] : nullptr;
            const auto v = numbers(row, width, fmt::format("row {} of '{}'", r, name));
            out.insert(out.end(), v.begin(), v.end());
        }
        return out;
    };
    const auto w = rows(key, 3, 4), p = rows("camera_to_pixel", 3, 3);
    const Map3 to_camera{
        {w[0], w[4], w[8]}, {w[1], w[5], w[9]}, {w[2], w[6], w[10]}, {w[3], w[7], w[11]}};
    const Map3 to_pixel{{p[0], p[3], p[6]}, {p[1], p[4], p[7]}, {p[2], p[5], p[8]}, {}};
    return inverse(to_pixel * to_camera);
}

// Sets where a light is, how it moves and how large it is.
void place_light(const FoundLight& light, Point3 towards, LightView& view) {
    const auto extents = numbers(light.json->find("half_extents"), 2,
                                 fmt::format("'half_extents' of light '{}'", light.name));
    if (extents[0] < 0 || extents[1] < 0)
        fail(fmt::format("'half_extents' of light '{}' are {}, {}; expected 0 or more", light.name,
                         extents[0], extents[1]));
    view.ax = extents[0], view.ay = extents[1];
    if (view.ax == 0 && view.ay == 0) view.shape = LightView::Shape::point;
    view.radius = view.ax;
    view.moves = light.json->find("origin_end") != nullptr;
    for (const size_t end : {0, 1}) {
        view.light_to_world[end] = light_frame(light, end && view.moves ? "_end" : "", towards);
        view.world_to_light[end] = inverse(view.light_to_world[end]);
    }
}
void place_mesh_light(const FoundLight& light, Point3 towards, LightView& view) {
    const WorldMesh mesh = world_mesh(light);
    view.moves = !mesh.close.empty();
    place_mesh(mesh, towards, fmt::format("light '{}'", light.name), view);
}

// Receivers in front of the light, at their own times: some of them.
struct Receivers {
    std::vector<double> x, y, w;  // X / w, Y / w, w
    size_t looked_at = 0;
    Point3 sum{};  // world, of all that hit something
    size_t hits = 0;
};
Receivers some_receivers(const LightView& view, const CameraSamples& from, size_t n) {
    Receivers out;
    const size_t step = n / 65536 + 1;
    for (size_t i = 0; i < n; i += step) {
        ++out.looked_at;
        if (!from.hit(i)) continue;
        const auto ends = from.ends(i);
        const Point3 p = view.from_camera(ends[0], ends[1], from.time(i));
        out.sum = out.sum + view.pixel_to_world[0].point(ends[0]);
        ++out.hits;
        if (!(p.z > 0)) continue;
        out.x.push_back(p.x / p.z);
        out.y.push_back(p.y / p.z);
        out.w.push_back(p.z);
    }
    return out;
}
// Makes room on the plane for what receivers aside see of a ball or a mesh: its outline lies farther
// out there.
void widen(const Receivers& some, LightView& view) {
    if (view.shape == LightView::Shape::sphere) {
        double out = view.radius;
        for (size_t i = 0; i < some.w.size(); ++i) {
            const double w = some.w[i], beside = std::hypot(some.x[i], some.y[i]) * w,
                         d = std::hypot(w, beside);
            const double angle = std::atan2(beside, w),
                         cone = std::asin(std::min(view.radius / d, 0.999));
            if (angle + cone < 1.5) out = std::max(out, w * std::tan(angle + cone) - beside);
        }
        view.ax = view.ay = std::min(1.01 * out, 3 * view.radius);
        return;
    }
    double x = view.ax, y = view.ay;
    const size_t receivers = some.w.size() / 2048 + 1, corners = view.triangles.size() / 64 + 1;
    for (size_t i = 0; i < some.w.size(); i += receivers)
        for (size_t k = 0; k < view.triangles.size(); k += corners)
            for (const Point3 p : {view.triangles[k].a, view.triangles[k].b, view.triangles[k].c}) {
                const double w = some.w[i];
                if (!(p.z < 0.9 * w)) continue;
                const double part = w / (w - p.z);
                x = std::max(x, std::abs(some.x[i] * w + (p.x - some.x[i] * w) * part));
                y = std::max(y, std::abs(some.y[i] * w + (p.y - some.y[i] * w) * part));
            }
    view.ax = std::min(1.01 * x, 3 * view.ax), view.ay = std::min(1.01 * y, 3 * view.ay);
}
double part_of(std::vector<double>& values, double part) {
    const size_t at = std::min(size_t(part * double(values.size())), values.size() - 1);
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(at), values.end());
    return values[at];
}

struct Bounds {
    double x0 = 1e300, y0 = 1e300, x1 = -1e300, y1 = -1e300;
    void add(double x, double y) {
        x0 = std::min(x0, x), x1 = std::max(x1, x);
        y0 = std::min(y0, y), y1 = std::max(y1, y);
    }
    void add(const Bounds& b) {
        x0 = std::min(x0, b.x0), x1 = std::max(x1, b.x1);
        y0 = std::min(y0, b.y0), y1 = std::max(y1, b.y1);
    }
};

}  // namespace

LightView fit_light_view(const Samples& samples, const FitOptions& options, Context& ctx) {
    samples.require("fit-light-view", {"xy", "z"});
    const FoundLight light = find_light(samples, options.light);
    LightView view;
    view.name = light.name;
    view.light = light.index;
    if (light.shape == "quad")
        view.shape = LightView::Shape::quad;
    else if (light.shape == "disc")
        view.shape = LightView::Shape::disc;
    else if (light.shape == "sphere")
        view.shape = LightView::Shape::sphere;
    else if (light.shape == "point" || light.shape == "spot")
        view.shape = LightView::Shape::point;
    else if (light.shape == "mesh")
        view.shape = LightView::Shape::mesh;
    else
        fail(
            fmt::format("light '{}' has shape '{}'; expected quad, disc, sphere, point, spot or mesh",
                        light.name, light.shape));
    const Json* camera = samples.meta.find("camera");
    const bool turns = camera && camera->find("world_to_camera_end");
    view.pixel_to_world = {pixel_to_world(samples, ""),
                           pixel_to_world(samples, turns ? "_end" : "")};
    view.spp = samples.mean_spp();

    const CameraSamples from(samples);
    Point3 middle;
    if (view.shape != LightView::Shape::quad && view.shape != LightView::Shape::disc) {
        const Receivers all = some_receivers(view, from, samples.size());
        if (all.hits > 0) middle = all.sum * (1.0 / double(all.hits));
    }
    if (view.shape == LightView::Shape::mesh)
        place_mesh_light(light, middle, view);
    else
        place_light(light, middle, view);
    // A line has some width, or its slopes over the lens would have no ratio.
    view.ax = std::max(view.ax, 1e-6 * view.ay), view.ay = std::max(view.ay, 1e-6 * view.ax);

    Receivers some = some_receivers(view, from, samples.size());
    if (some.w.empty())
        throw Error(fmt::format(
            "nothing that the samples hit lies in front of light '{}'; turn the light, or "
            "choose another one with 'light'",
            light.name));
    // Most of the receivers; what is near the light or beside it comes out larger.
    const double nearest = part_of(some.w, 0.01), farthest = part_of(some.w, 0.99);
    const double between = 2 / (1 / nearest + 1 / farthest);
    view.focus = options.focus > 0 ? options.focus : between;
    view.nearest = 1e-3 * between;
    if (!view.same_points()) widen(some, view);
    const double left = part_of(some.x, 0.02), right = part_of(some.x, 0.98);
    const double top = part_of(some.y, 0.02), bottom = part_of(some.y, 0.98);
    const double across = std::max(right - left, 1e-6), down = std::max(bottom - top, 1e-6);
    const double seen = double(samples.pixels()) * double(some.w.size()) / double(some.looked_at);
    view.k = options.pixels > 0 ? options.pixels : std::sqrt(std::max(seen, 1.0) / (across * down));

    const Bounds bounds = ctx.reduce(
        samples.size(), 65536, Bounds{},
        [&](size_t begin, size_t end) {
            Bounds b;
            for (size_t i = begin; i < end; ++i) {
                if (!from.hit(i)) continue;
                const auto ends = from.ends(i);
                const auto add = [&](Point3 p) {
                    if (!(p.z > view.nearest)) return;
                    for (const double l : {-1.0, 1.0}) {
                        const auto q = view.project(p, l, l);
                        b.add(q[0], q[1]);
                    }
                };
                const Point3 open = view.from_camera(ends[0], ends[1], 0),
                             way = view.from_camera(ends[0], ends[1], 1) - open;
                add(open);
                if (dot(way, way) > 0) add(open + way * from.time(i)), add(open + way);
            }
            return b;
        },
        [](Bounds a, const Bounds& b) {
            a.add(b);
            return a;
        });
    // Around what most receivers lie in, as far as the film can be.
    const auto fit = [&](double low, double high, double middle_of, int& size, double& shift) {
        const double margin = 4, half = 0.5 * widest_film;
        low = std::max(low - margin, middle_of - half),
        high = std::min(high + margin, middle_of + half);
        low = std::floor(low);
        size = std::max(1, int(std::ceil(high - low)));
        shift = -low;
    };
    fit(bounds.x0, bounds.x1, view.k * 0.5 * (left + right), view.width, view.cx);
    fit(bounds.y0, bounds.y1, view.k * 0.5 * (top + bottom), view.height, view.cy);
    return view;
}

double light_power(const Samples& samples, const std::string& name) {
    const FoundLight light = find_light(samples, name);
    const std::string what = fmt::format("light '{}'", light.name);
    const Point3 radiance = point_of(*light.json, "radiance", what);
    double size = 0;
    if (light.shape == "mesh") {
        const WorldMesh mesh = world_mesh(light);
        for (const auto& t : mesh.open) {
            const Point3 normal = cross(t[1] - t[0], t[2] - t[0]);
            size += 0.5 * std::sqrt(dot(normal, normal)) * (mesh.two_sided ? 2 : 1);
        }
    } else {
        const auto half =
            numbers(light.json->find("half_extents"), 2, fmt::format("'half_extents' of {}", what));
        size = light.shape == "quad"     ? 4 * half[0] * half[1]
               : light.shape == "disc"   ? std::numbers::pi * half[0] * half[1]
               : light.shape == "sphere" ? 4 * std::numbers::pi * half[0] * half[0]
                                         : 4;
    }
    return std::numbers::pi * size * dot(radiance, {0.2126, 0.7152, 0.0722});
}

}  // namespace weft::shadows
