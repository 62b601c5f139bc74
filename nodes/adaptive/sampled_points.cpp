#include "adaptive/sampled_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "samples/lens_shape.h"

namespace weft::adaptive {

Evaluated evaluate(const SamplerFunction& sampler, const std::vector<std::span<const float>>& axes,
                   std::uint64_t hidden_seed, Context& ctx) {
    const size_t n = axes[0].size(), stride = sampler.values(), more = stride - 3;
    Evaluated out;
    out.rgb.resize(3 * n);
    out.features.resize(more * n);
    out.broken = ctx.reduce(
        n, 4096, size_t(0),
        [&](size_t begin, size_t end) {
            std::vector<std::span<const float>> part;
            for (const auto& axis : axes) part.push_back(axis.subspan(begin, end - begin));
            std::vector<float> values(stride * (end - begin));
            sampler.evaluate({part}, hidden_seed, values);
            for (size_t i = begin; i < end; ++i) {
                const float* from = &values[stride * (i - begin)];
                std::copy_n(from + 3, more, out.features.begin() + std::ptrdiff_t(more * i));
                std::copy_n(from, 3, &out.rgb[3 * i]);
            }
            return blacken_broken(std::span(out.rgb).subspan(3 * begin, 3 * (end - begin)));
        },
        [](size_t a, size_t b) { return a + b; });
    return out;
}

size_t blacken_broken(std::span<float> rgb) {
    size_t broken = 0;
    for (size_t i = 0; i + 2 < rgb.size(); i += 3) {
        if (std::isfinite(rgb[i]) && std::isfinite(rgb[i + 1]) && std::isfinite(rgb[i + 2]))
            continue;
        std::fill_n(&rgb[i], 3, 0.0f);
        ++broken;
    }
    return broken;
}

void judge_broken(size_t broken, size_t all, Context& ctx) {
    if (broken == 0) return;
    const std::string what =
        fmt::format("{} of {} samples have radiance that is not finite", broken, all);
    if (100 * broken > all)
        ctx.fail(what + ", more than one in a hundred; look for divisions by zero in the renderer");
    ctx.warn(what + "; they count as black");
}

Samples samples_of(const SamplerFunction& sampler, const std::vector<std::span<const float>>& axes,
                   const Evaluated& values, std::span<const float> weight,
                   std::vector<std::uint32_t>& order) {
    const size_t n = axes[0].size();
    Samples s;
    s.width = sampler.width;
    s.height = sampler.height;
    s.color_space = sampler.color_space;
    const auto pixel_of = [&](size_t i) {
        const int x = std::min(int(axes[0][i] * float(s.width)), s.width - 1),
                  y = std::min(int(axes[1][i] * float(s.height)), s.height - 1);
        return size_t(y) * size_t(s.width) + size_t(x);
    };
    std::vector<std::uint64_t> first(s.pixels() + 1);
    for (size_t i = 0; i < n; ++i) ++first[pixel_of(i) + 1];
    for (size_t p = 0; p < s.pixels(); ++p) first[p + 1] += first[p];
    order.resize(n);
    std::vector<std::uint64_t> next(first.begin(), first.end() - 1);
    for (size_t i = 0; i < n; ++i) order[next[pixel_of(i)]++] = std::uint32_t(i);
    s.first = std::move(first);
    s.set_size(n);

    const auto column = [&](size_t components, const auto& of) {
        std::vector<float> made(components * n);
        for (size_t i = 0; i < n; ++i) of(size_t(order[i]), &made[components * i]);
        return made;
    };
    s.lens = sampler.lens;
    s.meta = sampler.meta;
    s.add("xy", 2, column(2, [&](size_t i, float* to) {
              to[0] = axes[0][i] * float(s.width);
              to[1] = axes[1][i] * float(s.height);
          }));
    const int u = sampler.axis("u"), v = sampler.axis("v");
    const Lens shape = sampler.lens.value_or(Lens{});
    if (u >= 0 && v >= 0)
        s.add("uv", 2, column(2, [&](size_t i, float* to) {
                  const auto on = on_lens(axes[size_t(u)][i], axes[size_t(v)][i], shape);
                  to[0] = on[0], to[1] = on[1];
              }));
    const int lu = sampler.axis("light-u"), lv = sampler.axis("light-v");
    const bool light = lu >= 0 && lv >= 0;
    if (light)
        s.add("light_uv", 2, column(2, [&](size_t i, float* to) {
                  to[0] = axes[size_t(lu)][i], to[1] = axes[size_t(lv)][i];
              }));
    const ShutterCurve shutter = shutter_of(sampler.meta);
    for (int d = 2; d < int(sampler.axes.size()); ++d) {
        if ((u >= 0 && v >= 0 && (d == u || d == v)) || (light && (d == lu || d == lv))) continue;
        std::string channel = sampler.axes[size_t(d)].name;
        std::replace(channel.begin(), channel.end(), '-', '_');
        const auto axis = axes[size_t(d)];
        const bool time = channel == "t";
        s.add(channel, 1, column(1, [&](size_t i, float* to) {
                  *to = time ? shutter.time(axis[i]) : axis[i];
              }));
    }
    s.add("rgb", 3,
          column(3, [&](size_t i, float* to) { std::copy_n(&values.rgb[3 * i], 3, to); }));
    size_t before = 0;
    for (const SamplerFeature& feature : sampler.features) {
        const auto k = size_t(feature.components);
        s.add(feature.name, feature.components, column(k, [&](size_t i, float* to) {
                  std::copy_n(&values.features[(sampler.values() - 3) * i + before], k, to);
              }));
        before += k;
    }
    if (!weight.empty())
        s.add("weight", 1, column(1, [&](size_t i, float* to) { *to = weight[i]; }));
    s.meta = s.meta_object();
    return s;
}

}  // namespace weft::adaptive
