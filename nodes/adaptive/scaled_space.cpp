#include "adaptive/scaled_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/error.h"
#include "light-field/points.h"

namespace weft::adaptive {
namespace {

float median(std::vector<float> of) {
    if (of.empty()) return 0;
    const auto middle = of.begin() + std::ptrdiff_t(of.size() / 2);
    std::nth_element(of.begin(), middle, of.end());
    return *middle;
}
std::string channel_of(std::string axis) {
    std::replace(axis.begin(), axis.end(), '-', '_');
    return axis;
}

}  // namespace

float median_motion(const Samples& samples) {
    if (!samples.has_motion() || samples.z().empty()) return 0;
    std::vector<float> speeds;
    const auto xy = samples.xy(), motion = samples.motion(), z = samples.z();
    for (size_t i = 0; i < samples.size(); ++i) {
        if (!std::isfinite(z[i])) continue;
        // Homogeneous: q w = q0 w0 + M (t - t0), so dq/dt = (M_xy - q M_w) / w at the sample's t.
        const float vx = (motion[3 * i] - xy[2 * i] * motion[3 * i + 2]) / z[i],
                    vy = (motion[3 * i + 1] - xy[2 * i + 1] * motion[3 * i + 2]) / z[i];
        const float speed = std::hypot(vx, vy);
        // What stands still says nothing of how long the axis has to be for what moves.
        if (std::isfinite(speed) && speed > 1e-3f) speeds.push_back(speed);
    }
    return median(std::move(speeds));
}

float median_defocus(const Samples& samples) {
    if (!samples.has_lens() || samples.z().empty()) return 0;
    std::vector<float> widths;
    for (const float z : samples.z())
        widths.push_back(2 * std::abs(samples.lens->c0 / z + samples.lens->c1));
    return median(std::move(widths));
}

void shorten_axes(std::vector<float>& extent, double samples_a_pixel) {
    constexpr double wanted = 1.2;  // px, the side of the box that a sample stands for
    constexpr float least = 4;      // px
    const double axes = double(extent.size());
    double unknown = 0, volume = 1 / samples_a_pixel;
    for (size_t d = 2; d < extent.size(); ++d) {
        unknown += extent[d] > 0 ? 0 : 1;
        volume *= extent[d] > 0 ? double(extent[d]) : double(usual_extent);
    }
    if (unknown == 0) return;
    const double by = std::pow(std::pow(wanted, axes) / volume, 1 / unknown);
    for (size_t d = 2; d < extent.size(); ++d)
        if (!(extent[d] > 0))
            extent[d] = std::clamp(float(by * double(usual_extent)), least, usual_extent);
}

ScaledSpace space_of(const LeafTree& leaves) {
    return {leaves.axes, leaves.extent};
}

ScaledSpace space_of(const Samples& samples) {
    ScaledSpace space{{"x", "y"}, {float(samples.width), float(samples.height)}};
    const auto add = [&](std::string axis, float extent) {
        space.axes.push_back(std::move(axis));
        space.extent.push_back(extent > 0 ? std::max(extent, 1.0f) : 0);
    };
    if (!samples.uv().empty())
        for (const char* axis : {"u", "v"}) add(axis, median_defocus(samples));
    if (!samples.t().empty()) add("t", median_motion(samples));
    if (!samples.values("light_uv").empty())
        for (const char* axis : {"light-u", "light-v"}) add(axis, 0);
    shorten_axes(space.extent, std::max(samples.mean_spp(), 1e-3));
    return space;
}

std::vector<std::vector<float>> places_in(const ScaledSpace& space, const Samples& samples,
                                          std::string_view who) {
    std::vector<std::vector<float>> places;
    for (size_t d = 0; d < space.axes.size(); ++d) {
        const std::string& axis = space.axes[d];
        const bool film = axis == "x" || axis == "y", lens = axis == "u" || axis == "v";
        const bool light = axis == "light-u" || axis == "light-v";
        const bool second = axis == "y" || axis == "v" || axis == "light-v";
        std::string name = film ? "xy" : lens ? "uv" : channel_of(axis);
        if (light && samples.values(name).empty()) name = "light_uv";
        const std::span<const float> from = samples.values(name);
        if (from.empty() && samples.size() > 0)
            throw Error(fmt::format("'{}' needs {} for axis {}; this buffer has no such channel",
                                    who, name, axis));
        const size_t components = samples.size() > 0 ? from.size() / samples.size() : 1;
        std::vector<float> to(samples.size());
        for (size_t i = 0; i < to.size(); ++i) {
            const float value = from[i * components + (components > 1 && second ? 1 : 0)];
            to[i] = film ? value : (lens ? 0.5f * (value + 1) : value) * space.extent[d];
        }
        places.push_back(std::move(to));
    }
    return places;
}

float place_of(const ScaledSpace& space, size_t axis, const Locations& at, size_t location) {
    const std::string& name = space.axes[axis];
    const float extent = space.extent[axis];
    if (name == "u") return 0.5f * (at.u_of(location) + 1) * extent;
    if (name == "v") return 0.5f * (at.v_of(location) + 1) * extent;
    if (name == "t") return at.t_of(location) * extent;
    // Axes that locations do not have: numbers of the slice, evenly spread together with the others
    // as far as the set goes, then multiples of irrational numbers.
    int others = 0;
    for (size_t d = 0; d < axis; ++d) {
        const std::string& before = space.axes[d];
        others += before != "x" && before != "y" && before != "u" && before != "v" && before != "t";
    }
    if (others < 2) return light_field::light_number(1, std::uint32_t(at.number), others) * extent;
    constexpr double steps[] = {0.41421356237309503, 0.73205080756887729, 0.2360679774997898,
                                0.6457513110645907};
    const double turned = (double(at.number) + 0.5) * steps[others % 4];
    return float(turned - std::floor(turned)) * extent;
}

}  // namespace weft::adaptive
