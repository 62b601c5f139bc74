#include "adaptive/request_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace weft::adaptive {
namespace {

// What requests say themselves.
bool is_place(const Channel& channel) {
    constexpr std::array<std::string_view, 11> places{"xy",       "uv",      "t",       "light_uv",
                                                      "light",    "light_u", "light_v", "bounce_u",
                                                      "bounce_v", "point",   "weight"};
    return std::find(places.begin(), places.end(), channel.name) != places.end();
}

}  // namespace

Samples request_points(const SamplerFunction& sampler,
                       const std::vector<std::span<const float>>& points, std::uint32_t first) {
    const size_t axes = sampler.dimensions(), n = points.empty() ? 0 : points[0].size();
    SamplerFunction plain = sampler;
    plain.features.clear();
    std::vector<std::uint32_t> order;
    std::vector<std::span<const float>> views = points;
    views.resize(axes);
    const Evaluated none{std::vector<float>(3 * n), {}, 0};
    Samples made = samples_of(plain, views, none, {}, order);
    std::vector<float> point(axes * n);
    std::vector<std::uint32_t> request(n);
    for (size_t i = 0; i < n; ++i) {
        request[i] = first + order[i];
        for (size_t d = 0; d < axes; ++d) point[axes * i + d] = points[d][order[i]];
    }
    made.add("point", int(axes), std::move(point));
    made.add_ids("request", std::move(request));
    made.meta = made.meta_object();
    return made;
}

std::vector<SamplerFeature> features_of(const Samples& answers) {
    std::vector<SamplerFeature> features;
    for (const Channel& channel : answers.channels)
        if (!channel.whole() && channel.name != "rgb" && channel.name != "request" &&
            !is_place(channel))
            features.push_back({channel.name, channel.components});
    return features;
}

Evaluated answers_of(const Samples& answers, const std::vector<SamplerFeature>& features,
                     std::uint32_t first, size_t count) {
    Evaluated made;
    size_t stride = 0;
    for (const SamplerFeature& feature : features) stride += size_t(feature.components);
    made.rgb.resize(3 * count);
    made.features.resize(stride * count);
    if (count == 0) return made;
    const Channel* keys = answers.find("request");
    if (!keys || !keys->whole() || keys->ids.size() != answers.size())
        throw Error("the results have no whole numbers 'request'; hand on those of the requests");
    if (answers.rgb().size() != 3 * answers.size())
        throw Error("the results have no 'rgb' of three numbers a sample");
    std::vector<bool> seen(count);
    for (size_t i = 0; i < answers.size(); ++i) {
        const std::uint32_t key = keys->ids[i];
        if (key < first || key - first >= count)
            throw Error(
                fmt::format("result {} answers request {}, which was not asked for: the requests "
                            "are {} to {}; answer the step's own",
                            i, key, first, first + count - 1));
        const size_t at = key - first;
        if (seen[at]) throw Error(fmt::format("request {} is answered twice", key));
        seen[at] = true;
        std::copy_n(&answers.rgb()[3 * i], 3, &made.rgb[3 * at]);
        size_t before = 0;
        for (const SamplerFeature& feature : features) {
            const auto k = size_t(feature.components);
            const std::span<const float> values = answers.values(feature.name);
            if (values.size() != k * answers.size())
                throw Error(
                    fmt::format("the results have no '{}' of {} numbers a sample, which "
                                "earlier ones had; render each step with the same channels",
                                feature.name, k));
            std::copy_n(&values[k * i], k, &made.features[stride * at + before]);
            before += k;
        }
    }
    const auto missing = std::find(seen.begin(), seen.end(), false);
    if (missing != seen.end())
        throw Error(
            fmt::format("{} results for {} requests; request {} is the first without one; a step "
                        "goes on once all are answered",
                        answers.size(), count, first + size_t(missing - seen.begin())));
    return made;
}

std::vector<std::vector<float>> points_of(const Samples& requests, size_t axes,
                                          std::string_view who) {
    const std::span<const float> point = requests.values("point");
    const size_t n = requests.size();
    if (point.size() != axes * n)
        throw Error(
            fmt::format("'{}' needs 'point' of {} numbers a sample, one for each axis of the "
                        "sampler; take the requests of adaptive-begin or adaptive-step, whole: "
                        "read-samples with channels [\"*\"]",
                        who, axes));
    std::vector<std::vector<float>> points(axes, std::vector<float>(n));
    for (size_t i = 0; i < n; ++i)
        for (size_t d = 0; d < axes; ++d) {
            const float x = point[axes * i + d];
            if (!(x >= 0 && x <= 1))
                throw Error(
                    fmt::format("'point' of sample {} is {} on axis {}; expected 0 to 1", i, x, d));
            points[d][i] = x;
        }
    return points;
}

}  // namespace weft::adaptive
