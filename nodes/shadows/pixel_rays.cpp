#include "shadows/pixel_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/error.h"

namespace weft::shadows {

PixelRays::PixelRays(const Samples& samples, const LightView& view, const Samples& light_samples,
                     std::string_view who)
    : samples_(samples),
      view_(view),
      camera_((samples.require(who, {"xy", "z"}), samples)),
      normal_(samples.values("geometric_normal")) {
    light_samples.require(who, {"uv", "z", "source"});
    if (light_samples.domain != "light")
        throw Error(
            fmt::format("'{}' needs light samples, these are of domain '{}'; make them by "
                        "render-light-samples, light-samples-from-file or "
                        "light-samples-from-camera",
                        who, light_samples.domain));
    if (normal_.empty()) normal_ = samples.values("normal");
    if (const Channel* id = samples.find("id")) ids_ = id->ids.view();
    l_ = light_samples.uv(), w_ = light_samples.z();
    source_ = light_samples.find("source")->ids.view();
    if (!std::is_sorted(source_.begin(), source_.end()) ||
        (!source_.empty() && source_.back() >= samples.size()))
        throw Error(
            fmt::format("'{}' needs the light samples of these samples, in their order; 'samples' "
                        "has {}",
                        who, samples.size()));
}

void PixelRays::find_places(int x, int y, std::vector<Point3>& places) const {
    places.clear();
    const auto range = samples_.of_pixel(size_t(y) * size_t(samples_.width) + size_t(x));
    for (size_t i = range.begin; i < range.end; ++i) {
        const auto ends = camera_.ends(i);
        places.push_back(view_.from_camera(ends[0], ends[1], camera_.time(i)));
    }
}

void PixelRays::of_pixel(int x, int y, std::span<const Point3> places,
                         std::vector<ShadowRay>& rays) const {
    rays.clear();
    const auto range = samples_.of_pixel(size_t(y) * size_t(samples_.width) + size_t(x));
    auto k =
        size_t(std::lower_bound(source_.begin(), source_.end(), range.begin) - source_.begin());
    for (; k < source_.size() && source_[k] < range.end; ++k) {
        const size_t i = source_[k];
        ShadowRay ray;
        ray.sample = std::uint32_t(i), ray.id = id(i);
        ray.receiver = places[i - range.begin];
        ray.light = {view_.ax * double(l_[2 * k]), view_.ay * double(l_[2 * k + 1]), 0};
        const double d2 = double(w_[k]);
        // Hits this near the receiver are the receiver itself (render-light-samples).
        ray.lit = !(d2 < ray.receiver.z * (1 - 2e-4));
        ray.slope = ray.lit ? 0 : ray.receiver.z / d2 - 1;
        rays.push_back(ray);
    }
}

PixelReceiver PixelRays::receiver(int x, int y, std::span<const Point3> places) const {
    const auto range = samples_.of_pixel(size_t(y) * size_t(samples_.width) + size_t(x));
    // The id of most hits; of equals the first seen.
    std::vector<std::pair<std::uint32_t, size_t>> seen;
    for (size_t i = range.begin; i < range.end; ++i) {
        if (!camera_.hit(i)) continue;
        const auto known =
            std::find_if(seen.begin(), seen.end(), [&](const auto& s) { return s.first == id(i); });
        if (known == seen.end())
            seen.emplace_back(id(i), 1);
        else
            ++known->second;
    }
    PixelReceiver out;
    size_t most = 0;
    for (const auto& [one, count] : seen)
        if (count > most) most = count, out.id = one;
    if (most == 0) return out;
    double z = 0;
    for (size_t i = range.begin; i < range.end; ++i) {
        if (!camera_.hit(i) || id(i) != out.id) continue;
        out.at = out.at + places[i - range.begin];
        z += double(samples_.z()[i]);
        if (normal_.empty()) continue;
        const double t = camera_.time(i);
        const Point3 n{double(normal_[3 * i]), double(normal_[3 * i + 1]),
                       double(normal_[3 * i + 2])};
        out.normal = out.normal + view_.from_world(n, t) - view_.from_world({0, 0, 0}, t);
    }
    out.at = out.at * (1 / double(most));
    const double length = std::sqrt(dot(out.normal, out.normal));
    out.normal = length > 0 ? out.normal * (1 / length) : Point3{};
    // Film positions come times z, so a pixel at depth z is z times a column wide.
    const Map3& film = view_.pixel_to_world[0];
    out.pixel = z / double(most) * std::pow(dot(film.x, film.x) * dot(film.y, film.y), 0.25);
    return out;
}

}  // namespace weft::shadows
