// pixel-filter: a picture from samples, each weighted where it truly lies on the film. `nearest`
// takes the one sample next to each pixel's centre instead: the naive grid, aliasing and all.
#include <fmt/format.h>

#include <atomic>

#include "filters/component_name.h"
#include "filters/pixel_filter_kernel.h"
#include "filters/pixel_filter_parameters.h"
#include "image/image.h"
#include "runtime/node.h"

namespace weft {
namespace {

enum class Rule { box, tent, gaussian, mitchell, lanczos, blackman_harris, nearest };

struct PixelFilterNode : FilterChoice {
    Rule filter = Rule::box;
    std::vector<std::string> channels{"rgb"};
    bool alpha = false;

    static void declare(Ports<PixelFilterNode>& node) {
        std::vector<std::string> rules = filter_names();
        rules.emplace_back("nearest");
        node.about("makes a picture of samples by a pixel filter at their true positions")
            .in<Samples>("samples", "any samples a pixel, constant or not; weight is honoured")
            .out<Image>("image", "the channels asked for; pixels that no sample reaches are 0")
            .choice("filter", &PixelFilterNode::filter, rules,
                    {.about = "nearest: the one sample next to the centre"});
        declare_filter_sizes(node, 32);
        node.param("channels", &PixelFilterNode::channels,
                   {.about =
                        "of the samples, as rgb, z, normal; one of three components becomes R G B"})
            .param("alpha", &PixelFilterNode::alpha,
                   {.about = "adds coverage as A, where the samples have it"});
    }

    Cost cost(const Shapes& in) const {
        const Shape samples = in["samples"];
        const double pixels = double(samples.width) * double(samples.height);
        const double components = 3.0 * double(channels.size()) + alpha;
        const double radius = radius_of(chosen()), taps = 4 * (radius + 1) * (radius + 1);
        return {{{"image",
                  {samples.width, samples.height, std::int64_t(components), 0,
                   pixels * components * 4}}},
                double(samples.width) * (rows_at_once + 2 * radius) * (components + 4) * 8,
                double(samples.records) * taps * components};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const;

  private:
    static constexpr int rows_at_once = 16;

    PixelFilter chosen() const {
        FilterChoice choice = *this;
        choice.kind = filter == Rule::nearest ? FilterKind::box : FilterKind(filter);
        return make_filter(choice);
    }
    std::vector<const Channel*> wanted(const Samples& samples) const;
    static std::vector<std::string> names_of(const std::vector<const Channel*>& channels);
};

std::vector<const Channel*> PixelFilterNode::wanted(const Samples& samples) const {
    std::vector<const Channel*> found;
    for (const std::string& name : channels) {
        samples.require("pixel-filter", {"xy", name});
        const Channel* channel = samples.find(name);
        if (channel->whole())
            throw Error(
                fmt::format("'pixel-filter' cannot take means of {}: it holds whole numbers; ask "
                            "for another channel",
                            name));
        found.push_back(channel);
    }
    if (found.empty())
        throw Error("'pixel-filter' has no channels to filter; give some, for example [\"rgb\"]");
    const Channel* coverage = alpha ? samples.find("alpha") : nullptr;
    if (coverage && std::find(found.begin(), found.end(), coverage) == found.end())
        found.push_back(coverage);
    return found;
}

// rgb is R G B, alpha A, any other channel carries its name, components after a dot.
std::vector<std::string> PixelFilterNode::names_of(const std::vector<const Channel*>& channels) {
    std::vector<std::string> names;
    const bool has_rgb =
        std::any_of(channels.begin(), channels.end(), [](auto* c) { return c->name == "rgb"; });
    for (const Channel* channel : channels) {
        const bool as_color =
            channel->name == "rgb" ||
            (!has_rgb && channel == channels[0] && channel->components == 3 &&
             (channels.size() == 1 || (channels.size() == 2 && channels[1]->name == "alpha")));
        for (int i = 0; i < channel->components; ++i) {
            if (channel->name == "alpha")
                names.emplace_back("A");
            else if (as_color)
                names.emplace_back(1, "RGB"[i]);
            else
                names.push_back(component_name(*channel, i));
        }
    }
    return names;
}

void PixelFilterNode::run(const Inputs& in, Outputs& out, Context& ctx) const {
    const Samples& samples = in.get<Samples>("samples");
    if (samples.domain != "camera")
        ctx.fail(
            fmt::format("'pixel-filter' needs samples in pixel order, these are of domain '{}'",
                        samples.domain));
    const auto found = wanted(samples);
    const auto input = kernel::filter_input(samples, found);
    const PixelFilter shape = chosen();

    Image image(samples.width, samples.height, names_of(found));
    const bool radiance = std::all_of(found.begin(), found.end(), [](const Channel* channel) {
        return channel->role == Role::radiance || channel->name == "albedo" ||
               channel->name == "alpha";
    });
    image.color_space = radiance ? samples.color_space : "Raw";
    std::atomic<size_t> missing{0};
    ctx.parallel_rows(
        samples.height,
        [&](Rows rows) {
            missing +=
                filter == Rule::nearest
                    ? kernel::nearest_rows(input, rows.begin, rows.end, image.row(rows.begin))
                    : kernel::filter_rows(input, shape, rows.begin, rows.end,
                                          image.row(rows.begin));
        },
        rows_at_once);
    if (missing > 0)
        ctx.warn(fmt::format("{} of {} pixels have no sample within the filter; they are 0",
                             missing.load(), samples.pixels()));
    out.set("image", std::move(image));
}

WEFT_NODE(PixelFilterNode, "pixel-filter", 1);

}  // namespace
}  // namespace weft
