// pixel-features: what filters of pictures go by: of each pixel's own samples the mean colour, the
// mean features (normal, albedo, whatever has the role) and the variances of these means.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>

#include "filters/component_name.h"
#include "filters/pixel_features_kernel.h"
#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct PixelFeatures {
    std::string color = "rgb";
    std::vector<std::string> channels;

    static void declare(Ports<PixelFeatures>& node) {
        node.about(
                "means of colour and features over each pixel's samples, and the variances of "
                "these means: what 'cross-bilateral-image' and 'non-local-means' go by")
            .in<Samples>("samples", "any samples a pixel, constant or not; weight is honoured")
            .out<Image>("color", "R G B, each pixel's mean; 0 where a pixel has no sample")
            .out<Image>("color-variance",
                        "R G B, of these means as if samples were independent; of a single sample "
                        "that of its 3 x 3 pixels")
            .out<Image>("features",
                        "normal.x normal.y ..., the means of the feature channels; none where the "
                        "samples have no features")
            .out<Image>("features-variance", "of these means, channels alike")
            .out<Image>("count", "samples of each pixel that made its colour: 0 where it has none")
            .param("color", &PixelFeatures::color,
                   {.about = "the channel of three components that becomes R G B"})
            .param("channels", &PixelFeatures::channels,
                   {.about = "feature channels, as normal, albedo, z; empty: all that have the "
                             "role 'feature'"});
    }

    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        // Features by role are not known before the samples are: at most the six standard ones.
        const auto layers = std::int64_t(channels.empty() ? 18 : 3 * channels.size());
        const double work = double(s.records) * 4 * double(3 + layers);
        return {{{"color", image_shape(s.width, s.height, 3)},
                 {"color-variance", image_shape(s.width, s.height, 3)},
                 {"features", image_shape(s.width, s.height, layers)},
                 {"features-variance", image_shape(s.width, s.height, layers)},
                 {"count", image_shape(s.width, s.height, 1)}},
                0,
                work};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const;

  private:
    static constexpr int rows_at_once = 16;

    std::vector<const Channel*> wanted_features(const Samples& samples) const;
    static const Channel* numbers(const Samples& samples, const std::string& name);
};

const Channel* PixelFeatures::numbers(const Samples& samples, const std::string& name) {
    samples.require("pixel-features", {"xy", name});
    const Channel* channel = samples.find(name);
    if (channel->whole())
        throw Error(fmt::format(
            "'pixel-features' cannot take means of {}: it holds whole numbers; ask for another "
            "channel",
            name));
    return channel;
}

std::vector<const Channel*> PixelFeatures::wanted_features(const Samples& samples) const {
    std::vector<const Channel*> found;
    for (const std::string& name : channels) found.push_back(numbers(samples, name));
    if (channels.empty())
        for (const Channel& channel : samples.channels)
            if (channel.role == Role::feature && !channel.whole()) found.push_back(&channel);
    return found;
}

// Means, variances where wanted, and counts of some channels, into pictures whose channels are
// theirs in order.
void moments(const Samples& samples, const std::vector<const Channel*>& channels, int rows_at_once,
             Image& mean, Image* variance, Image* count, Context& ctx) {
    size_t at = 0;
    const auto stride = size_t(mean.channels());
    for (const Channel* channel : channels) {
        const kernel::PixelMoments of{&samples, channel->values.view(), samples.values("weight"),
                                      channel->components, channel->role != Role::radiance};
        std::mutex access;
        kernel::DroppedSamples dropped{0, samples.size()};
        ctx.parallel_rows(
            samples.height,
            [&](Rows rows) {
                const auto found = kernel::moment_rows(
                    of, rows.begin, rows.end, stride, mean.pixels().data() + at,
                    variance ? variance->pixels().data() + at : nullptr,
                    count && channel == channels.front() ? count->pixels().data() : nullptr);
                if (found.count == 0) return;
                const std::lock_guard lock(access);
                dropped.count += found.count;
                dropped.first = std::min(dropped.first, found.first);
            },
            rows_at_once);
        if (dropped.count > 0) {
            size_t pixel = 0;
            while (samples.of_pixel(pixel).end <= dropped.first) ++pixel;
            ctx.warn(fmt::format(
                "{}: {} samples are not finite and left out; first: pixel ({}, {}), sample {}",
                channel->name, dropped.count, pixel % size_t(samples.width),
                pixel / size_t(samples.width), dropped.first - samples.of_pixel(pixel).begin));
        }
        at += size_t(channel->components);
    }
}

void PixelFeatures::run(const Inputs& in, Outputs& out, Context& ctx) const {
    const Samples& samples = in.get<Samples>("samples");
    if (samples.domain != "camera")
        ctx.fail(
            fmt::format("'pixel-features' needs samples in pixel order, these are of domain '{}'",
                        samples.domain));
    const Channel* radiance = numbers(samples, color);
    if (radiance->components != 3)
        ctx.fail(
            fmt::format("'color' is {}, of {} components; expected a channel of three, such as rgb",
                        radiance->name, radiance->components));
    const std::vector<const Channel*> features = wanted_features(samples);
    std::vector<std::string> layers;
    for (const Channel* channel : features)
        for (int i = 0; i < channel->components; ++i) layers.push_back(component_name(*channel, i));

    const auto make = [&](const std::vector<const Channel*>& of,
                          const std::vector<std::string>& names, const std::string& port,
                          const std::string& space, bool counts) {
        Image mean(samples.width, samples.height, names);
        Image variance = mean, count(counts ? samples.width : 0, samples.height, 1);
        mean.color_space = space;
        variance.color_space = count.color_space = "Raw";
        const bool with_variance = out.wanted(port + "-variance");
        moments(samples, of, rows_at_once, mean, with_variance ? &variance : nullptr,
                counts ? &count : nullptr, ctx);
        if (counts) {
            const auto values = count.pixels();
            const auto empty = std::count(values.begin(), values.end(), 0.0f);
            if (empty > 0)
                ctx.warn(fmt::format("{} of {} pixels have no sample; they are 0, and 'count' is",
                                     empty, samples.pixels()));
            if (out.wanted("count")) out.set("count", std::move(count));
        }
        if (out.wanted(port)) out.set(port, std::move(mean));
        if (with_variance) out.set(port + "-variance", std::move(variance));
    };
    make({radiance}, {"R", "G", "B"}, "color", samples.color_space, true);
    if (out.wanted("features") || out.wanted("features-variance"))
        make(features, layers, "features", "Raw", false);
}

WEFT_NODE(PixelFeatures, "pixel-features", 1);

}  // namespace
}  // namespace weft
