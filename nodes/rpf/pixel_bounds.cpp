#include "rpf/pixel_bounds.h"

#include <algorithm>
#include <cmath>

namespace weft::rpf {
namespace {

// Of features `first` on. As few numbers may lie far off all others, four deviations are enough.
std::vector<PixelBounds::Scale> find_scales(const SampleVectors& v, size_t first, Context& ctx) {
    struct Sums {
        double sum = 0, squares = 0, low = 1e300, high = -1e300;
    };
    using All = std::vector<Sums>;
    const size_t features = v.components.size() - first;
    const All all = ctx.reduce(
        v.size(), 32768, All(features),
        [&](size_t begin, size_t end) {
            All some(features);
            for (size_t i = begin; i < end; ++i)
                for (size_t k = 0; k < features; ++k) {
                    const auto x = double(v.of(i)[first + k]);
                    some[k].sum += x, some[k].squares += x * x;
                    some[k].low = std::min(some[k].low, x);
                    some[k].high = std::max(some[k].high, x);
                }
            return some;
        },
        [](All a, const All& b) {
            for (size_t k = 0; k < a.size(); ++k) {
                a[k].sum += b[k].sum, a[k].squares += b[k].squares;
                a[k].low = std::min(a[k].low, b[k].low);
                a[k].high = std::max(a[k].high, b[k].high);
            }
            return a;
        });
    std::vector<PixelBounds::Scale> scales;
    for (const Sums& of : all) {
        const auto n = double(v.size());
        const double mean = of.sum / n,
                     far = 4 * std::sqrt(std::max(0.0, of.squares / n - mean * mean)),
                     low = std::max(of.low, mean - far), high = std::min(of.high, mean + far);
        scales.push_back({low, 253.9 / std::max(high - low, 1e-6 * std::abs(low) + 1e-30)});
    }
    return scales;
}

}  // namespace

void find_pixel_bounds(SampleVectors& v, Context& ctx) {
    constexpr double few = 4;
    constexpr size_t padding = 64;
    if (!v.whole.empty() || v.samples.mean_spp() < few) return;
    const auto is_feature = [](const VectorComponent& c) { return c.role == Role::feature; };
    PixelBounds& bounds = v.bounds;
    bounds.first = size_t(std::find_if(v.components.begin(), v.components.end(), is_feature) -
                          v.components.begin());
    bounds.scales = find_scales(v, bounds.first, ctx);
    const size_t pixels = v.samples.pixels();
    bounds.pitch = pixels + padding;
    for (auto* of : {&bounds.low, &bounds.high}) of->resize(bounds.scales.size() * bounds.pitch);
    ctx.parallel(bounds.pitch, 4096, [&](size_t begin, size_t end) {
        for (size_t pixel = begin; pixel < end; ++pixel) {
            const auto [from, to] = pixel < pixels ? v.samples.of_pixel(pixel) : Samples::Range{};
            for (size_t k = 0; k < bounds.scales.size(); ++k) {
                std::uint8_t low = 255, high = 0;
                for (size_t i = from; i < to; ++i) {
                    const std::uint8_t code =
                        bounds.scales[k].code(double(v.of(i)[bounds.first + k]));
                    low = std::min(low, code);
                    high = std::max(high, code);
                }
                bounds.low[k * bounds.pitch + pixel] = low;
                bounds.high[k * bounds.pitch + pixel] = high;
            }
        }
    });
}

void find_near_codes(const PixelBounds& bounds, std::span<const float> centre,
                     std::span<const float> bound, std::vector<NearCodes>& to) {
    to.clear();
    for (size_t k = 0; k < bounds.scales.size(); ++k) {
        const auto c = double(centre[bounds.first + k]), b = double(bound[bounds.first + k]);
        if (!std::isfinite(b)) continue;
        const PixelBounds::Scale& scale = bounds.scales[k];
        // What comparisons may be off by rounding. What has the code of an end is on either side.
        const double rounding = 1e-6 * (std::abs(c) + b), few = b - rounding, many = b + rounding;
        const std::uint8_t *const low = &bounds.low[k * bounds.pitch],
                                  *const high = &bounds.high[k * bounds.pitch];
        const int first = scale.code(c - few), last = scale.code(c + few);
        const bool known = first < 255 && last > 0;  // else past those that numbers have
        to.push_back({low, high, scale.code(c - many), scale.code(c + many),
                      std::uint8_t(known ? first + 1 : 255), std::uint8_t(known ? last - 1 : 0)});
    }
}

}  // namespace weft::rpf
