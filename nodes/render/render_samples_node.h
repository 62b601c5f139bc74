// What render-samples and render-tiles share: samples a pixel, and what is said of them.
#pragma once
#include "render/render_node.h"

namespace weft::render {

struct RenderSamplesNode : RenderNode {
    int spp = 16;
    std::vector<std::string> channels{"basic"};
    std::shared_ptr<Prepared> prepared = std::make_shared<Prepared>();

    template <class Node>
    static void declare_samples(Ports<Node>& node) {
        node.param("spp", static_cast<int Node::*>(&RenderSamplesNode::spp),
                   {.unit = "samples", .min = 1, .max = 1 << 20, .about = "samples a pixel"})
            .param("channels",
                   static_cast<std::vector<std::string> Node::*>(&RenderSamplesNode::channels),
                   {.about = "names as in sample files; basic: xy uv t z motion rgb alpha; all: "
                             "everything"});
        RenderNode::declare_shared(node);
    }

    // As large as they may become: whether there is a lens or motion is not known beforehand.
    Shape samples_shape(const Shapes& in) const {
        const Shape counts = in["counts"];
        const std::int64_t w = counts.width > 0 ? counts.width : width,
                           h = counts.height > 0 ? counts.height : height;
        const double samples = double(w) * double(h) * spp;
        return {w, h, 0, std::int64_t(samples),
                samples * 4 * double(channel_set(channels, true, true).numbers())};
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
        const auto moves = [](const std::vector<Affine>& keys) {
            return KeyedMotion(keys).moving();
        };
        bool motion = moves(scene.camera.to_world);
        for (const Instance& i : scene.instances)
            motion = motion || i.to_world.size() > 1 || scene.meshes[size_t(i.mesh)].steps > 1;
        for (const Light& l : scene.lights)
            motion = motion || (l.area() && l.visible && l.to_world.size() > 1);
        return channel_set(channels, scene.camera.lens_radius > 0, motion);
    }
};

}  // namespace weft::render
