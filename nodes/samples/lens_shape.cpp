#include "samples/lens_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace weft {

std::array<float, 2> on_lens(float a, float b, const Lens& lens) {
    if (lens.blades >= 3) {
        // A blade's triangle, then a point in it: evenly from the middle outwards, evenly along the
        // edge.
        const float scaled = a * float(lens.blades);
        const int blade = std::min(int(scaled), lens.blades - 1);
        const float along = scaled - float(blade), out = std::sqrt(b);
        const float step = 2 * std::numbers::pi_v<float> / float(lens.blades);
        const float from = lens.rotation + float(blade) * step, to = from + step;
        return {out * ((1 - along) * std::cos(from) + along * std::cos(to)),
                out * ((1 - along) * std::sin(from) + along * std::sin(to))};
    }
    const float p = 2 * a - 1, r = 2 * b - 1;
    if (p == 0 && r == 0) return {0, 0};
    constexpr float quarter = std::numbers::pi_v<float> / 4;
    const bool wide = std::abs(p) > std::abs(r);
    const float radius = wide ? p : r;
    const float angle = wide ? quarter * (r / p) : 2 * quarter - quarter * (p / r);
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

ShutterCurve::ShutterCurve(std::span<const float> curve) {
    if (curve.size() < 2) return;
    double area = 0;
    for (size_t i = 0; i + 1 < curve.size(); ++i)
        area += 0.5 * (std::max(double(curve[i]), 0.0) + std::max(double(curve[i + 1]), 0.0));
    if (!(area > 0) || !std::isfinite(area)) return;
    area /= double(curve.size() - 1);
    for (const float value : curve) open_.push_back(float(std::max(double(value), 0.0) / area));
    if (std::all_of(open_.begin(), open_.end(), [&](float v) { return v == open_[0]; })) {
        open_.clear();
        return;
    }
    double sum = 0;
    for (size_t i = 0; i < open_.size(); ++i) {
        sum_.push_back(sum);
        if (i + 1 < open_.size())
            sum += 0.5 * (double(open_[i]) + double(open_[i + 1])) / double(open_.size() - 1);
    }
}

ShutterCurve shutter_of(const Json& meta) {
    std::vector<float> curve;
    if (!meta.is(Json::Kind::object)) return {};
    const Json* list = meta.find("shutter_curve");
    if (!list || !list->is(Json::Kind::list)) return {};
    for (const Json& open : list->items)
        if (open.is(Json::Kind::number)) curve.push_back(float(open.number));
    return ShutterCurve(curve);
}

float ShutterCurve::time(float number) const {
    if (constant()) return number;
    const double target = double(number) * sum_.back();
    const size_t steps = open_.size() - 1;
    size_t i = size_t(std::upper_bound(sum_.begin(), sum_.end(), target) - sum_.begin());
    i = std::clamp<size_t>(i, 1, steps) - 1;
    // Of the step: a x + (b - a) x^2 / 2 = rest, solved so that a = b is no exception.
    const double a = double(open_[i]), b = double(open_[i + 1]);
    const double rest = (target - sum_[i]) * double(steps);
    const double root = std::sqrt(std::max(a * a + 2 * (b - a) * rest, 0.0));
    const double x = a + root > 0 ? 2 * rest / (a + root) : 0;
    return std::min(float((double(i) + std::clamp(x, 0.0, 1.0)) / double(steps)), 0x1.fffffep-1f);
}

float ShutterCurve::openness(float t) const {
    if (constant()) return 1;
    const float place = std::clamp(t, 0.0f, 1.0f) * float(open_.size() - 1);
    const size_t i = std::min(size_t(place), open_.size() - 2);
    const float s = place - float(i);
    return open_[i] + (open_[i + 1] - open_[i]) * s;
}

}  // namespace weft
