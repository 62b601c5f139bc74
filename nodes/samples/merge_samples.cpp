// merge-samples: two sample buffers of one picture as one, pixel by pixel: what a second pass found
// is added to what a first had.
#include <fmt/format.h>

#include <algorithm>

#include "runtime/node.h"
#include "samples/samples.h"

namespace weft {
namespace {

struct MergeSamples {
    static void declare(Ports<MergeSamples>& node) {
        node.about("the samples of several buffers of one picture, pixel by pixel")
            .in<Samples>("samples",
                         "of one size and one camera, in order; a buffer may be empty, or leave "
                         "pixels empty",
                         Need::variadic)
            .out<Samples>("samples", "the channels that all of them have; meta of the first");
    }
    Cost cost(const Shapes& in) const {
        double bytes = 0;
        std::int64_t records = 0;
        Shape first;
        for (const auto& [port, shape] : in.ports) {
            if (first.width == 0) first = shape;
            bytes += shape.bytes, records += shape.records;
        }
        return {{{"samples", {first.width, first.height, 0, records, bytes}}}, 0, bytes};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const std::vector<const Samples*> parts = in.all<Samples>("samples");
        const std::vector<std::string>& names = in.names("samples");
        if (parts.empty()) ctx.fail("no samples to merge; link 'samples'");
        const Samples& first = *parts.front();
        for (size_t p = 0; p < parts.size(); ++p) {
            const Samples& part = *parts[p];
            const std::string& name = p < names.size() ? names[p] : "samples";
            if (part.domain != "camera")
                ctx.fail(fmt::format("'{}' is of domain '{}', without pixels; expected 'camera'",
                                     name, part.domain));
            if (part.width != first.width || part.height != first.height)
                ctx.fail(fmt::format("'{}' is {} x {}, the first buffer {} x {}; expected one size",
                                     name, part.width, part.height, first.width, first.height));
            if (part.lens.value_or(Lens{}) != first.lens.value_or(Lens{}) ||
                part.color_space != first.color_space)
                ctx.fail(
                    fmt::format("'{}' has another lens or colour space than the first buffer; "
                                "expected passes of one camera",
                                name));
        }

        Samples all;
        all.width = first.width, all.height = first.height;
        all.color_space = first.color_space, all.lens = first.lens, all.meta = first.meta;
        std::vector<std::uint64_t> offsets(first.pixels() + 1, 0);
        bool even = true;
        for (size_t pixel = 0; pixel < first.pixels(); ++pixel) {
            offsets[pixel + 1] = offsets[pixel];
            for (const Samples* part : parts) {
                const auto range = part->of_pixel(pixel);
                offsets[pixel + 1] += range.end - range.begin;
            }
            even = even && offsets[pixel + 1] - offsets[pixel] == offsets[1];
        }
        all.set_size(offsets.back());
        even = even && offsets[1] > 0;
        all.spp = even ? int(offsets[1]) : 0;

        for (const Channel& channel : first.channels) {
            Channel joined{channel.name, channel.components, channel.role, {}, {}};
            const auto gather = [&](auto get, auto& array) {
                std::vector<std::remove_cvref_t<decltype(get(channel)[0])>> values(
                    all.size() * size_t(channel.components));
                ctx.parallel_rows(all.height, [&](Rows rows) {
                    const size_t begin = size_t(rows.begin) * size_t(all.width),
                                 end = size_t(rows.end) * size_t(all.width),
                                 k = size_t(channel.components);
                    size_t to = offsets[begin] * k;
                    for (size_t pixel = begin; pixel < end; ++pixel)
                        for (const Samples* part : parts) {
                            const auto range = part->of_pixel(pixel);
                            if (range.begin == range.end) continue;
                            const auto from = get(*part->find(channel.name));
                            to = size_t(std::copy(from.begin() + std::ptrdiff_t(range.begin * k),
                                                  from.begin() + std::ptrdiff_t(range.end * k),
                                                  values.begin() + std::ptrdiff_t(to)) -
                                        values.begin());
                        }
                });
                array = std::move(values);
            };
            bool whole = false, there = true;
            for (const Samples* part : parts) {
                const Channel* c = part->find(channel.name);
                there = there && c && c->components == channel.components;
                whole = whole || (c && c->whole());
            }
            if (!there) continue;
            if (whole)
                gather([](const Channel& c) { return c.ids.view(); }, joined.ids);
            else
                gather([](const Channel& c) { return c.values.view(); }, joined.values);
            all.add(std::move(joined));
        }
        if (!even) all.first = std::move(offsets);
        all.meta = all.meta_object();
        out.set("samples", std::move(all));
    }
};

WEFT_NODE(MergeSamples, "merge-samples", 1)

}  // namespace
}  // namespace weft
