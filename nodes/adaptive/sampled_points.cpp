#include "adaptive/sampled_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "samples/samplers.h"

namespace weft::adaptive {

std::vector<float> evaluate(const SamplerFunction& sampler,
                            const std::vector<std::span<const float>>& axes,
                            std::uint64_t hidden_seed, size_t& broken, Context& ctx) {
    const size_t n = axes[0].size();
    std::vector<float> rgb(3 * n);
    broken += ctx.reduce(
        n, 4096, size_t(0),
        [&](size_t begin, size_t end) {
            std::vector<std::span<const float>> part;
            for (const auto& axis : axes) part.push_back(axis.subspan(begin, end - begin));
            const std::span<float> to(&rgb[3 * begin], 3 * (end - begin));
            sampler.evaluate({part}, hidden_seed, to);
            size_t bad = 0;
            for (size_t i = 0; i < to.size(); i += 3) {
                if (std::isfinite(to[i]) && std::isfinite(to[i + 1]) && std::isfinite(to[i + 2]))
                    continue;
                to[i] = to[i + 1] = to[i + 2] = 0;
                ++bad;
            }
            return bad;
        },
        [](size_t a, size_t b) { return a + b; });
    return rgb;
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
                   std::span<const float> rgb, std::span<const float> weight,
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
        std::vector<float> values(components * n);
        for (size_t i = 0; i < n; ++i) of(size_t(order[i]), &values[components * i]);
        return values;
    };
    s.add("xy", 2, column(2, [&](size_t i, float* to) {
              to[0] = axes[0][i] * float(s.width);
              to[1] = axes[1][i] * float(s.height);
          }));
    const int u = sampler.axis("u"), v = sampler.axis("v");
    if (u >= 0 && v >= 0)
        s.add("uv", 2, column(2, [&](size_t i, float* to) {
                  const Disk disk = concentric_disk(axes[size_t(u)][i], axes[size_t(v)][i]);
                  to[0] = disk.u, to[1] = disk.v;
              }));
    for (size_t d = 2; d < sampler.axes.size(); ++d) {
        const std::string& name = sampler.axes[d].name;
        if (name == "u" || name == "v") continue;
        std::string channel = name;
        std::replace(channel.begin(), channel.end(), '-', '_');
        s.add(channel, 1, column(1, [&](size_t i, float* to) { *to = axes[d][i]; }));
    }
    s.add("rgb", 3, column(3, [&](size_t i, float* to) { std::copy_n(&rgb[3 * i], 3, to); }));
    if (!weight.empty())
        s.add("weight", 1, column(1, [&](size_t i, float* to) { *to = weight[i]; }));
    s.meta = s.meta_object();
    return s;
}

}  // namespace weft::adaptive
