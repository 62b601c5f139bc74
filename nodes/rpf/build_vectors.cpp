// build-vectors: which channels of a sample buffer take part in random parameter filtering, and
// their numbers side by side. Parts are given by the channels' roles: what a renderer calls random
// is random, whatever its name. Source: Sen and Darabi 2012, Sec. 3.  Departure: channels that
// never change are left out, as they have no say.
#include <fmt/format.h>

#include <cmath>

#include "rpf/pixel_bounds.h"
#include "rpf/pixel_statistics.h"
#include "runtime/node.h"
#include "samples/file_bytes.h"

namespace weft {
namespace {

struct BuildVectors {
    std::vector<std::string> random, features;
    bool pixels = true, bounds = true;

    static void declare(Ports<BuildVectors>& node) {
        node.about(
                "position, random parameters and features of each sample, side by side: what "
                "random parameter filtering goes by")
            .in<Samples>("samples",
                         "xy, rgb, and what has the role random or feature; read-samples gives all "
                         "with channels [\"*\"]")
            .out<SampleVectors>("vectors", "a vector a sample")
            .param(
                "random", &BuildVectors::random,
                {.about =
                     "random parameters, as uv, t, light_uv; empty: all channels of role 'random'"})
            .param("features", &BuildVectors::features,
                   {.about = "features, as normal, albedo; empty: all channels of role 'feature'"})
            .param("pixels", &BuildVectors::pixels,
                   {.about = "find what the samples of each pixel say together, too: "
                             "bilateral-filter-pixels goes by that"})
            .param("bounds", &BuildVectors::bounds,
                   {.about = "find between which numbers the samples of each pixel are: draws "
                             "gaussian and distinct of neighbourhoods are sooner done by that"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        const double bytes = 128 * double(s.records);
        return {{{"vectors", {s.width, s.height, 0, s.records, bytes}}}, 0, 64 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        samples.require("build-vectors", {"xy", "rgb"});
        SampleVectors v;
        v.samples = samples;
        std::vector<const Channel*> channels;
        const auto add = [&](const Channel& channel, Role role) {
            if (role != Role::position && constant(channel, ctx)) return;
            v.channels.push_back(channel.name);
            for (int k = 0; k < channel.components; ++k)
                v.components.push_back({role, int(channels.size())});
            channels.push_back(&channel);
        };
        add(*samples.find("xy"), Role::position);
        for (const Channel* c : chosen(samples, random, Role::random)) add(*c, Role::random);
        for (const Channel* c : chosen(samples, features, Role::feature)) add(*c, Role::feature);
        fill(channels, v, ctx);
        if (bounds) rpf::find_pixel_bounds(v, ctx);
        if (pixels) rpf::find_pixel_statistics(v, ctx);
        out.set("vectors", std::move(v));
    }

  private:
    static std::vector<const Channel*> chosen(const Samples& samples,
                                              const std::vector<std::string>& names, Role role) {
        std::vector<const Channel*> found;
        for (const std::string& name : names) {
            const Channel* c = samples.find(name);
            if (!c && is_standard_channel(name)) continue;  // a pinhole has no uv
            if (!c) samples.require("build-vectors", {std::string_view(name)});
            if (c->whole())
                throw Error(
                    fmt::format("'build-vectors' cannot compare {}: it holds whole numbers that "
                                "name things; ask for another channel",
                                name));
            found.push_back(c);
        }
        if (names.empty())
            for (const Channel& c : samples.channels)
                if (c.role == role && !c.whole()) found.push_back(&c);
        return found;
    }

    static bool constant(const Channel& c, Context& ctx) {
        const size_t n = c.values.size(), k = size_t(c.components);
        return ctx.reduce(
            n / k, 65536, true,
            [&](size_t begin, size_t end) {
                for (size_t i = begin * k; i < end * k; ++i)
                    if (c.values[i] != c.values[i % k]) return false;
                return true;
            },
            [](bool a, bool b) { return a && b; });
    }

    // Samples with a number that is not finite take no part. Pages of a mapped file that only their
    // vectors are made of go as these grow.
    static void fill(const std::vector<const Channel*>& channels, SampleVectors& v, Context& ctx) {
        const size_t n = v.size();
        const size_t stride = v.stride();
        v.values.resize(n * stride + SampleVectors::padding);
        std::fill(v.values.begin() + std::ptrdiff_t(n * stride), v.values.end(),
                  0.0f);  // kernels compare what they read there
        std::vector<std::uint8_t> whole(n);
        const auto rgb = v.samples.rgb();
        const size_t broken = ctx.reduce(
            n, 32768, size_t(0),
            [&](size_t begin, size_t end) {
                size_t bad = 0;
                for (size_t i = begin; i < end; ++i) {
                    float* to = &v.values[i * stride];
                    bool finite = true;
                    const auto add = [&](float x) {
                        const bool good = std::isfinite(x);
                        *to++ = good ? x : 0.0f;
                        finite &= good;
                    };
                    for (const Channel* c : channels)
                        for (size_t k = 0; k < size_t(c->components); ++k)
                            add(c->values[i * size_t(c->components) + k]);
                    for (size_t c = 0; c < 3; ++c) add(rgb[3 * i + c]);
                    whole[i] = finite;
                    bad += !finite;
                }
                for (const Channel* c : channels) {
                    const auto k = size_t(c->components);
                    if (c->role != Role::position)
                        forget_pages(c->values.view().subspan(begin * k, (end - begin) * k));
                }
                return bad;
            },
            [](size_t a, size_t b) { return a + b; });
        if (broken == 0) return;
        const size_t first =
            size_t(std::find(whole.begin(), whole.end(), std::uint8_t(0)) - whole.begin());
        ctx.warn(
            fmt::format("{} of {} samples hold a feature or random parameter that is not finite, "
                        "the first is sample {}: they are not filtered, "
                        "nor is anything filtered by them",
                        broken, n, first));
        v.whole = std::move(whole);
    }
};

WEFT_NODE(BuildVectors, "build-vectors", 2)

}  // namespace
}  // namespace weft
