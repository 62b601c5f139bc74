// recentre-samples: a sample buffer as a pinhole at half time would have seen it: each sample is carried to lens centre
// and half time along its own trajectory and put into the pixel it comes to lie in. What lens and shutter blur is sharp
// there, so that a filter of pictures or samples meets one surface a pixel and the noise of light alone.
// return-samples brings what became of their colours back to the samples as they were.
// Source: Lehtinen et al. 2011, Sec. 3.1 (trajectories).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "light-field/build_hierarchy_kernel.h"
#include "runtime/node.h"
#include "samples/take_samples.h"

namespace weft {
namespace {
using namespace light_field;

constexpr std::string_view source = "source_sample";

struct RecentreSamples {
    std::vector<std::string> channels;

    static void declare(Ports<RecentreSamples>& node) {
        node.about("the samples as seen from the lens centre at half time; those past the picture's edges are put into the pixels there")
            .in<Samples>("samples", "xy, z and rgb; uv with a lens, t and motion where it has them")
            .out<Samples>("samples", "in pixels of their new places, any number a pixel, without lens and motion; source_sample says which is which")
            .param("channels", &RecentreSamples::channels, {.about = "that are carried along beside xy and rgb, as normal; empty: all"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"samples", {s.width, s.height, 0, s.records, s.bytes + 8 * double(s.records)}}}, 12 * double(s.records), 0};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& from = in.get<Samples>("samples");
        from.require("recentre-samples", {"xy", "z", "rgb"});
        const size_t n = from.size();
        const Lens lens = from.has_lens() ? *from.lens : Lens{};
        const Places places = places_of(from);
        std::vector<float> xy(2 * n);
        std::vector<std::uint32_t> pixel(n);
        ctx.parallel_for(
            n,
            [&](size_t i) {
                const Recentred p = recentred(places, lens, i);
                const bool there = p.W > 0;  // else behind the camera at half time: where it was seen
                const float x = there ? p.X / p.W : places.xy[2 * i], y = there ? p.Y / p.W : places.xy[2 * i + 1];
                xy[2 * i] = x;
                xy[2 * i + 1] = y;
                const auto column = std::clamp(std::floor(x), 0.0f, float(from.width - 1)), row = std::clamp(std::floor(y), 0.0f, float(from.height - 1));
                pixel[i] = std::uint32_t(row) * std::uint32_t(from.width) + std::uint32_t(column);
            },
            4096);
        // Pixels one after another, samples of a pixel in the order they had.
        std::vector<std::uint64_t> first(from.pixels() + 1, 0);
        for (const std::uint32_t p : pixel) ++first[p + 1];
        for (size_t p = 0; p < from.pixels(); ++p) first[p + 1] += first[p];
        std::vector<std::uint64_t> next(first.begin(), first.end() - 1);
        std::vector<std::uint32_t> order(n);
        for (size_t i = 0; i < n; ++i) order[next[pixel[i]]++] = std::uint32_t(i);

        Samples to = from;
        to.spp = 0;
        to.first = std::move(first);
        to.lens.reset();
        to.channels.clear();
        for (Channel c : from.channels)
            if (is_carried(c.name)) {
                if (c.name == "xy") c.values = std::move(xy);
                to.add(take_samples(c, order, ctx));
            }
        to.add_ids(std::string(source), order);
        out.set("samples", std::move(to));
    }

  private:
    bool is_carried(const std::string& name) const {
        if (name == "uv" || name == "t" || name == "motion" || name == source) return false;
        return channels.empty() || name == "xy" || name == "rgb" || std::find(channels.begin(), channels.end(), name) != channels.end();
    }
};

struct ReturnSamples {
    static void declare(Ports<ReturnSamples>& node) {
        node.about("samples with the colours that their recentred twins were given")
            .in<Samples>("samples", "as they were before recentre-samples")
            .in<Samples>("recentred", "what became of those it made: rgb is read, by source_sample")
            .out<Samples>("samples", "all channels as they were, but rgb");
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"samples", {s.width, s.height, 0, s.records, s.bytes + 12 * double(s.records)}}}, 0, 0};
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples &samples = in.get<Samples>("samples"), &moved = in.get<Samples>("recentred");
        const Channel* ids = moved.find(source);
        if (!ids || !ids->whole() || moved.size() != samples.size())
            throw Error(fmt::format("'recentred' does not hold the {} samples that recentre-samples makes of 'samples'; link what came of those", samples.size()));
        std::vector<float> rgb(3 * samples.size());
        const auto colors = moved.rgb();
        ctx.parallel_for(
            samples.size(),
            [&](size_t i) {
                const size_t to = std::min<size_t>(ids->ids[i], samples.size() - 1);
                std::copy_n(&colors[3 * i], 3, &rgb[3 * to]);
            },
            8192);
        Samples result = samples;
        result.add("rgb", 3, std::move(rgb));
        out.set("samples", std::move(result));
    }
};

WEFT_NODE(RecentreSamples, "recentre-samples", 1)
WEFT_NODE(ReturnSamples, "return-samples", 1)

}  // namespace
}  // namespace weft
