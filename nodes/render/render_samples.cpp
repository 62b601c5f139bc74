// render-samples: a scene's samples, each with its place on film, lens and shutter, its light,
// depth and motion, and whatever else is asked for (path_tracer.h).
#include <fmt/format.h>

#include "render/render_samples_node.h"
#include "render/sample_buffer.h"
#include "samples/sample_meta.h"

namespace weft::render {

void warn_of_deviation(const PathTracer& tracer, Context& ctx) {
    const float deviation = tracer.largest_deviation();
    if (deviation > 0.01f)
        ctx.warn(fmt::format(
            "some things turn or bend: 'motion' is the straight line between both ends of the "
            "shutter, and samples lie up to {:.3g} px from it",
            deviation));
}

namespace {

struct RenderSamples : RenderSamplesNode {
    static void declare(Ports<RenderSamples>& node) {
        node.about(
                "renders a scene into a sample buffer: defocus, motion blur and soft light, a "
                "sample a ray")
            .in<Scene>("scene", "what to render, from its camera")
            .in<Image>("counts",
                       "samples of each pixel, in its first channel; spp, width and height are "
                       "then not looked at",
                       Need::optional)
            .out<Samples>(
                "samples",
                "the channels asked for; a pinhole has no uv, a still scene no t and motion");
        declare_samples(node);
    }

    Cost cost(const Shapes& in) const {
        const Shape shape = samples_shape(in);
        return {{{"samples", shape}}, 16e6, double(shape.records) * 1000 * std::max(max_depth, 1)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        prepared->release();
        const auto made = prepare(in, ctx);
        const ChannelSet& set = made->tracer.options().channels;
        ChannelArrays arrays;
        arrays.resize(set, made->plan.samples());
        render_rows(made->tracer, made->plan, 0, made->plan.height(), 0, made->workers, arrays,
                    ctx);
        Samples samples = empty_samples(made->tracer, made->plan);
        give_channels(set, std::move(arrays), samples);
        warn_of_deviation(made->tracer, ctx);
        prepared->release();
        out.set("samples", std::move(samples));
    }

    // Shards: bands of rows.
    static constexpr int rows_in_piece = 16;
    size_t pieces(const Inputs& in) const {
        prepared->release();  // another run may have another scene, at the same place
        const Image* counts = in.find<Image>("counts");
        return size_t((counts ? counts->height() : height) + rows_in_piece - 1) / rows_in_piece;
    }
    void piece(const Inputs& in, size_t index, ByteWriter& to, Context& ctx) const {
        // One piece prepares while others wait for it: it must not take up their work meanwhile.
        PlainContext alone;
        const auto made = prepare(in, alone);
        const SamplePlan& plan = made->plan;
        const int begin = int(index) * rows_in_piece,
                  end = std::min(begin + rows_in_piece, plan.height());
        const std::uint64_t from = plan.first(0, begin);
        const std::uint64_t past = end < plan.height() ? plan.first(0, end) : plan.samples();
        const ChannelSet& set = made->tracer.options().channels;
        ChannelArrays arrays;
        arrays.resize(set, past - from);
        render_rows(made->tracer, plan, begin, end, from, made->workers, arrays, ctx);
        to.put(from);
        to.put(std::uint8_t(index == 0));
        if (index == 0) {
            const Samples head = empty_samples(made->tracer, plan);
            to.put_text(head.meta_object().dump());
            to.put(std::uint64_t(head.size()));
            to.put_all(plan.offsets());
            to.put(set);
        }
        for (const ChannelId c : set.list()) {
            if (info_of(c).whole)
                to.put_all(arrays.ids[size_t(c)]);
            else
                to.put_all(arrays.values[size_t(c)]);
        }
    }
    void join(const Pieces& all, Outputs& out, Context&) const {
        Samples samples;
        ChannelSet set;
        ChannelArrays arrays;
        for (size_t i = 0; i < all.size(); ++i) {
            ByteReader from = all.read(i);
            const auto offset = from.take<std::uint64_t>();
            if ((from.take<std::uint8_t>() != 0) != (i == 0))
                throw Error("is not the piece it should be");
            if (i == 0) {
                read_meta(from.take_text(), "samples", samples);
                samples.set_size(from.take<std::uint64_t>());
                std::vector<std::uint64_t> offsets = from.take_all<std::uint64_t>();
                if (!offsets.empty()) samples.first = std::move(offsets);
                set = from.take<ChannelSet>();
                arrays.resize(set, samples.size());
            }
            for (const ChannelId c : set.list()) {
                const size_t k = size_t(info_of(c).components);
                const auto put = [&](const auto& values, auto& to) {
                    if (offset * k > to.size() || values.size() > to.size() - offset * k)
                        throw Error("holds more samples than the picture has");
                    std::copy(values.begin(), values.end(),
                              to.begin() + std::ptrdiff_t(offset * k));
                };
                if (info_of(c).whole)
                    put(from.take_all<std::uint32_t>(), arrays.ids[size_t(c)]);
                else
                    put(from.take_all<float>(), arrays.values[size_t(c)]);
            }
        }
        give_channels(set, std::move(arrays), samples);
        out.set("samples", std::move(samples));
    }
};

WEFT_NODE(RenderSamples, "render-samples", 3);

}  // namespace
}  // namespace weft::render
