// render-samples: a scene's samples, each with its place on film, lens and shutter, its light,
// depth and motion, and whatever else is asked for (path_tracer.h).
#include <fmt/format.h>

#include "render/render_node.h"
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

struct RenderSamples : RenderNode {
    int spp = 16;
    std::vector<std::string> channels{"basic"};
    std::shared_ptr<Prepared> prepared = std::make_shared<Prepared>();

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
                "the channels asked for; a pinhole has no uv, a still scene no t and motion")
            .param("spp", &RenderSamples::spp,
                   {.unit = "samples", .min = 1, .max = 1 << 20, .about = "samples a pixel"})
            .param("channels", &RenderSamples::channels,
                   {.about = "names as in sample files; basic: xy uv t z motion rgb alpha; all: "
                             "everything"});
        declare_shared(node);
    }

    Cost cost(const Shapes& in) const {
        const Shape counts = in["counts"];
        const std::int64_t w = counts.width > 0 ? counts.width : width,
                           h = counts.height > 0 ? counts.height : height;
        const double samples = double(w) * double(h) * spp;
        const double bytes = samples * 4 * double(channel_set(channels, true, true).numbers());
        return {{{"samples", {w, h, 0, std::int64_t(samples), bytes}}},
                16e6,
                samples * 1000 * std::max(max_depth, 1)};
    }

    std::shared_ptr<Prepared::Made> prepare(const Inputs& in, Context& ctx) const {
        const Scene& scene = in.get<Scene>("scene");
        return prepared->get(scene, [&] {
            const Image* counts = in.find<Image>("counts");
            RenderOptions o = options();
            if (counts) o.width = counts->width(), o.height = counts->height();
            o.channels = channels_of(scene);
            return std::make_shared<Prepared::Made>(
                scene, o, counts ? SamplePlan(*counts) : SamplePlan(width, height, spp), ctx);
        });
    }
    ChannelSet channels_of(const Scene& scene) const {
        const auto moves = [](const std::vector<Affine>& keys) { return Placement(keys).moving(); };
        bool motion = moves(scene.camera.to_world);
        for (const Instance& i : scene.instances)
            motion = motion || i.to_world.size() > 1 || scene.meshes[size_t(i.mesh)].steps > 1;
        for (const Light& l : scene.lights)
            motion = motion || (l.area() && l.visible && l.to_world.size() > 1);
        return channel_set(channels, scene.camera.lens_radius > 0, motion);
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
        const Image* counts = in.find<Image>("counts");
        return size_t((counts ? counts->height() : height) + rows_in_piece - 1) / rows_in_piece;
    }
    void piece(const Inputs& in, size_t index, ByteWriter& to, Context& ctx) const {
        const auto made = prepare(in, ctx);
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

WEFT_NODE(RenderSamples, "render-samples", 1);

}  // namespace
}  // namespace weft::render
