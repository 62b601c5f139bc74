// What analytic-samples and analytic-reference share: the scene, the size, and how it is sampled.
#pragma once
#include "runtime/node.h"
#include "samples/analytic_scene.h"

namespace weft {

enum class AnalyticScene { garden, step, plane, disc, layers };  // as analytic_scene_names()

struct AnalyticNode {
    AnalyticScene scene = AnalyticScene::garden;
    int width = 640, height = 360;
    std::uint64_t seed = 1;
    Sampler sampler = Sampler::sobol;
    float aperture = 1, shutter = 1;

    std::string scene_name() const { return analytic_scene_names().at(size_t(scene)); }
    AnalyticOptions options(int spp) const {
        return {width, height, spp, seed, sampler, aperture, shutter};
    }

    // Shards: a piece is a band of rows.
    size_t pieces(const Inputs&) const { return size_t((height + analytic_band - 1) / analytic_band); }
    AnalyticOptions options_of_piece(int spp, size_t index) const {
        AnalyticOptions some = options(spp);
        some.first_row = int(index) * analytic_band;
        some.end_row = std::min(height, some.first_row + analytic_band);
        return some;
    }

    template <class Node>
    static void declare_shared(Ports<Node>& node) {
        const auto of = []<class T>(T AnalyticNode::*field) {
            return static_cast<T Node::*>(field);
        };
        node.choice("scene", of(&AnalyticNode::scene), analytic_scene_names(),
                    {.about = "which of the built-in scenes"})
            .param("width", of(&AnalyticNode::width),
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .param("height", of(&AnalyticNode::height),
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .param("seed", of(&AnalyticNode::seed), {.about = "another number, other samples"})
            .choice("sampler", of(&AnalyticNode::sampler), {"independent", "stratified", "sobol"},
                    {.about = "how samples fill pixel, lens and shutter; sobol is Owen-scrambled"})
            .param("aperture", of(&AnalyticNode::aperture),
                   {.min = 0, .max = 100, .about = "times the scene's lens radius; 0: a pinhole"})
            .param("shutter", of(&AnalyticNode::shutter),
                   {.min = -1, .max = 1, .about = "times the scene's motion; 0: still"});
    }
};

}  // namespace weft
