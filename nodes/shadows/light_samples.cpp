#include "shadows/light_samples.h"

#include <fmt/format.h>

#include <algorithm>

namespace weft::shadows {
namespace {

// Drops the places whose z is 0, `components` numbers each, and gives back what they took.
template <class T>
void compact(std::vector<T>& values, const std::vector<float>& z, size_t components, size_t kept) {
    size_t to = 0;
    for (size_t i = 0; i < z.size(); ++i) {
        if (z[i] == 0) continue;
        for (size_t c = 0; c < components; ++c) values[to++] = values[i * components + c];
    }
    values.resize(kept * components);
    values.shrink_to_fit();
}

}  // namespace

void warn_of(const Unseen& unseen, const LightView& view, Context& ctx) {
    if (unseen.rays > 0 && unseen.stopped == unseen.rays)
        ctx.warn(
            fmt::format("none of {} shadow rays from light '{}' gets to what the camera sees: it "
                        "lies inside geometry or behind it, and adds nothing to the picture; move "
                        "it, or leave its shadows out",
                        unseen.rays, view.name));
    if (unseen.too_near > 0)
        ctx.warn(
            fmt::format("{} light samples lie within {:.3g} of light '{}' and are left out: it "
                        "touches what it shines on",
                        unseen.too_near, view.nearest, view.name));
    if (unseen.outside > 0)
        ctx.warn(
            fmt::format("{} receivers lie outside the view of light '{}' and get no shadow of it; "
                        "fit-light-view of the same samples holds all that are in front of it",
                        unseen.outside, view.name));
}

LightSampleArrays::LightSampleArrays(size_t places)
    : xy_(2 * places),
      uv_(2 * places),
      t_(places),
      z_(places),
      motion_(3 * places),
      gradient_(2 * places),
      source_(places) {}

bool LightSampleArrays::seen(const LightView& view, const LightHit& hit, Unseen& unseen) {
    ++unseen.rays;
    unseen.stopped += hit.stopped;
    if (!(hit.at.z > view.nearest)) {
        ++unseen.too_near;
        return false;
    }
    const auto q = view.project(hit.at, hit.lx, hit.ly);
    if (q[0] >= 0 && q[0] < view.width && q[1] >= 0 && q[1] < view.height)
        return std::isfinite(hit.at.z) && std::isfinite(dot(hit.motion, hit.motion));
    ++unseen.outside;
    return false;
}

void LightSampleArrays::set(size_t i, const LightView& view, const LightHit& hit) {
    const auto q = view.project(hit.at, hit.lx, hit.ly);
    xy_[2 * i] = float(q[0]), xy_[2 * i + 1] = float(q[1]);
    uv_[2 * i] = float(hit.lx), uv_[2 * i + 1] = float(hit.ly);
    t_[i] = float(hit.t);
    z_[i] = float(hit.at.z);
    motion_[3 * i] = float(view.k * hit.motion.x + view.cx * hit.motion.z);
    motion_[3 * i + 1] = float(view.k * hit.motion.y + view.cy * hit.motion.z);
    motion_[3 * i + 2] = float(hit.motion.z);
    if (dot(hit.normal, hit.normal) > 0) {
        const auto slope = view.inverse_depth_gradient(hit.at, hit.normal);
        const double w2 = hit.at.z * hit.at.z;
        gradient_[2 * i] = float(-w2 * slope[0]), gradient_[2 * i + 1] = float(-w2 * slope[1]);
    }
    source_[i] = hit.source;
}

Samples LightSampleArrays::take(const LightView& view, const Samples& camera, double part) && {
    const size_t kept = z_.size() - size_t(std::count(z_.begin(), z_.end(), 0.0f));
    const bool still = std::all_of(motion_.begin(), motion_.end(), [](float m) { return m == 0; });
    Samples out;
    out.width = view.width, out.height = view.height;
    out.domain = "light";
    out.color_space = camera.color_space;
    out.set_size(kept);
    if (view.shape != LightView::Shape::point) out.lens = view.lens();
    out.meta = Json::object();
    // How dense samples are where a pixel of the light's film is as large as one of the camera's.
    Json light = Json::object();
    light.set("name", view.name);
    light.set("camera_spp", view.spp * part);
    out.meta.set("light", std::move(light));
    if (const Json* curve = camera.meta.find("shutter_curve"))
        out.meta.set("shutter_curve", *curve);

    const auto give = [&](const char* name, int components, std::vector<float>& values) {
        compact(values, z_, size_t(components), kept);
        out.add(name, components, std::move(values));
    };
    give("xy", 2, xy_);
    give("uv", 2, uv_);
    if (!still) {
        give("t", 1, t_);
        give("motion", 3, motion_);
    }
    give("z_gradient", 2, gradient_);
    compact(source_, z_, 1, kept);
    out.add_ids("source", std::move(source_));
    std::erase(z_, 0.0f);
    z_.shrink_to_fit();
    out.add("z", 1, std::move(z_));
    // No pixel order: all lie in the last pixel, for whoever asks.
    std::vector<std::uint64_t> first(out.pixels() + 1, 0);
    first.back() = kept;
    out.first = std::move(first);
    out.meta = out.meta_object();
    return out;
}

Disk light_numbers(std::uint64_t seed, int x, int y, int count, std::uint32_t index) {
    // The fourth pair: those before are the film's, the lens's and the shutter's.
    return sample_sequence(Sampler::sobol, seed, x, y, count)(index, 3);
}

}  // namespace weft::shadows
