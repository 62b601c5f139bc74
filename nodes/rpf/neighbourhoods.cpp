// neighbourhoods: the samples around each block of pixels that are enough like its own: what
// dependence is estimated from, and what the filter averages. Source: Sen and Darabi 2012, Sec. 4.1
// (draw), Algorithm 2 (clustering).  Departures: the draw may be a fixed well-spread set; a block
// may be more than one pixel.
#include <cmath>
#include <limits>

#include "rpf/draws.h"
#include "rpf/kernels.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace rpf;

enum class ClusterOn { all, first_hit };

struct NeighbourhoodsNode {
    int box = 55, draws = 0, block = 1;
    float fraction = 0.5f, sigma = 0.25f;
    DrawRule draw_rule = DrawRule::stratified;
    bool cluster = true;
    ClusterOn cluster_on = ClusterOn::all;
    float cluster_sigma = 3, position_sigma = 30, cluster_epsilon = 0.1f;
    std::uint64_t seed = 1;

    static void declare(Ports<NeighbourhoodsNode>& node) {
        node.about(
                "the samples around each block of pixels, normalised. In pixels of fewer than 4 "
                "samples what is near is judged by those of 3 x 3 pixels")
            .in<SampleVectors>("vectors", "position, random parameters and features of each sample")
            .out<Neighbourhoods>("neighbourhoods", "a block and its neighbours a batch")
            .param("box", &NeighbourhoodsNode::box,
                   {.unit = "px",
                    .min = 1,
                    .max = 255,
                    .about = "side of the square around the block"})
            .param("draws", &NeighbourhoodsNode::draws,
                   {.min = 0,
                    .max = 1 << 18,
                    .about = "samples looked at; 0: 'fraction' of those in the box"})
            .param(
                "fraction", &NeighbourhoodsNode::fraction,
                {.min = 0.001, .max = 8, .about = "of the samples in the box that are looked at"})
            .param("sigma", &NeighbourhoodsNode::sigma,
                   {.unit = "box",
                    .min = 0.05,
                    .max = 4,
                    .about = "deviation of the Gaussian they are drawn by"})
            .choice("draw", &NeighbourhoodsNode::draw_rule, {"stratified", "gaussian", "distinct"},
                    {.about = "stratified: one well-spread set of places, mirrored by chance; "
                              "gaussian: independent, repeats and all; distinct: "
                              "independent, a pixel's first samples and none twice"})
            .param("block", &NeighbourhoodsNode::block,
                   {.unit = "px",
                    .min = 1,
                    .max = 8,
                    .about = "side of the block of pixels that share a neighbourhood"})
            .param("cluster", &NeighbourhoodsNode::cluster,
                   {.about = "leave out samples whose features are far from the block's own"})
            .choice(
                "cluster-on", &NeighbourhoodsNode::cluster_on, {"all", "first-hit"},
                {.about = "features that decide this; first-hit: not those whose name ends in 2"})
            .param("cluster-sigma", &NeighbourhoodsNode::cluster_sigma,
                   {.min = 0,
                    .max = 1e6,
                    .about = "deviations of the block's own that a feature may be off"})
            .param(
                "position-sigma", &NeighbourhoodsNode::position_sigma,
                {.min = 0, .max = 1e6, .about = "the same of world positions, which always vary"})
            .param("cluster-epsilon", &NeighbourhoodsNode::cluster_epsilon,
                   {.min = 0,
                    .max = 1e6,
                    .about = "what it may be off at least, where the deviation is less than this"})
            .param("seed", &NeighbourhoodsNode::seed, {.about = "of all random choices"});
    }

    struct Clustered {
        size_t component;
        float sigmas;  // deviations of the block's own that it may be off
    };
    struct Scratch {
        std::vector<Clustered> clustered;
        Places places;
        DrawSettings by;
        DrawScratch draw;
        std::vector<NearCodes> near;
        DrawnSamples drawn;
        std::vector<std::uint32_t> statistics;
        std::vector<float> centre, bound;
        LayoutScratch layout;
        const SampleVectors* of = nullptr;
    };

    Extent extent(const Inputs& in) const {
        const Samples& s = in.get<SampleVectors>("vectors").samples;
        return {s.width, s.height};
    }

    bool next(const Inputs& in, size_t index, Outputs& out, Scratch& scratch) const {
        const SampleVectors& v = in.get<SampleVectors>("vectors");
        const Tile& tile = in.tile();
        // Blocks are aligned to the picture, so a tile may have parts of some.
        const int bx0 = tile.x0 / block, by0 = tile.y0 / block,
                  across = (tile.x1 + block - 1) / block - bx0,
                  down = (tile.y1 + block - 1) / block - by0;
        if (index >= size_t(across) * size_t(down)) return false;
        const int x0 = (bx0 + int(index % size_t(across))) * block,
                  y0 = (by0 + int(index / size_t(across))) * block;
        const PixelBlock at{x0, y0, std::min(x0 + block, v.samples.width),
                            std::min(y0 + block, v.samples.height)};

        Neighbourhoods& n = out.get<Neighbourhoods>("neighbourhoods");
        n.vectors = &v;
        n.block = at;
        n.own_record.assign(1,
                            std::uint32_t(std::max(y0, tile.y0)) * std::uint32_t(v.samples.width) +
                                std::uint32_t(std::max(x0, tile.x0)));
        n.pixels = n.own_record;
        n.parents = {};
        prepare(v, scratch);
        take_own(v, at, n);
        find_bounds(v, at, n, scratch);
        find_near_codes(v.bounds, scratch.centre, scratch.bound, scratch.near);
        scratch.drawn.clear();
        if (n.own() > 0)
            draw(v.samples, scratch.by, scratch.places, at, scratch.near, scratch.draw,
                 scratch.drawn);
        if (!v.whole.empty()) leave_out_broken(v, scratch.drawn);
        // An odd number of cache lines, so that rows never all fall into one set of a cache.
        n.pitch = ((n.own() + scratch.drawn.sample.size() + Neighbourhoods::padding - 1) /
                       Neighbourhoods::padding |
                   1) *
                  Neighbourhoods::padding;
        WEFT_PICK(take_near)
        (v, scratch.drawn, scratch.centre.data(), scratch.bound.data(), scratch.layout, n);
        return true;
    }

  private:
    void prepare(const SampleVectors& v, Scratch& scratch) const {
        if (scratch.of == &v) return;
        scratch.of = &v;
        const double spp = v.samples.mean_spp();
        scratch.by = {
            draw_rule, box, size_t(draws), sigma * float(box), std::max(1, int(std::lround(spp))),
            seed};
        if (draws == 0)
            scratch.by.draws =
                size_t(std::lround(double(fraction) * double(box) * double(box) * spp));
        scratch.places = make_places(scratch.by);
        scratch.clustered.clear();
        for (size_t k = 0; k < v.components.size() && cluster; ++k) {
            const std::string& name = v.channels[size_t(v.components[k].channel)];
            if (v.components[k].role == Role::feature &&
                (cluster_on == ClusterOn::all || !name.ends_with('2')))
                scratch.clustered.push_back(
                    {k, name.starts_with("position") ? position_sigma : cluster_sigma});
        }
    }

    static void take_own(const SampleVectors& v, PixelBlock at, Neighbourhoods& n) {
        n.own_pixels.clear();
        n.own_offset.assign(1, 0);
        n.sample.clear();
        for (int y = at.y0; y < at.y1; ++y)
            for (int x = at.x0; x < at.x1; ++x) {
                const auto pixel = size_t(y) * size_t(v.samples.width) + size_t(x);
                const auto [begin, end] = v.samples.of_pixel(pixel);
                for (size_t i = begin; i < end; ++i)
                    if (v.is_whole(i)) n.sample.push_back(std::uint32_t(i));
                n.own_pixels.push_back(std::uint32_t(pixel));
                n.own_offset.push_back(std::uint32_t(n.sample.size()));
            }
    }

    static void leave_out_broken(const SampleVectors& v, DrawnSamples& drawn) {
        std::erase_if(drawn.sample, [&](std::uint32_t i) { return !v.is_whole(i); });
        drawn.stretches.clear();
        drawn.extend(drawn.sample.size(), PixelNear::some);
    }

    // What features may be for a sample to be near the mean of the block's own. As long as whole
    // vectors read.
    void find_bounds(const SampleVectors& v, PixelBlock at, const Neighbourhoods& n,
                     Scratch& scratch) const {
        scratch.centre.assign(v.stride() + Neighbourhoods::padding, 0.0f);
        scratch.bound.assign(v.stride() + Neighbourhoods::padding,
                             std::numeric_limits<float>::infinity());
        if (n.own() == 0) return;
        std::vector<std::uint32_t>& from = scratch.statistics;
        from.assign(n.sample.begin(), n.sample.begin() + std::ptrdiff_t(n.own()));
        if (from.size() < 4) {
            from.clear();
            const Samples& s = v.samples;
            for (int y = std::max(0, at.y0 - 1); y < std::min(s.height, at.y1 + 1); ++y)
                for (int x = std::max(0, at.x0 - 1); x < std::min(s.width, at.x1 + 1); ++x) {
                    const auto [begin, end] = s.of_pixel(size_t(y) * size_t(s.width) + size_t(x));
                    for (size_t i = begin; i < end; ++i)
                        if (v.is_whole(i)) from.push_back(std::uint32_t(i));
                }
        }
        for (const auto& [k, sigmas] : scratch.clustered) {
            double sum = 0, squares = 0;
            const double base = double(v.of(from[0])[k]);
            for (const std::uint32_t i : from) {
                const double x = double(v.of(i)[k]) - base;
                sum += x;
                squares += x * x;
            }
            const double count = double(from.size()), mean = sum / count;
            const auto deviation = float(
                std::sqrt(std::max(0.0, squares - count * mean * mean) / std::max(1.0, count - 1)));
            scratch.centre[k] = float(base + mean);
            const float far = sigmas * deviation;
            scratch.bound[k] = deviation < cluster_epsilon ? std::max(far, cluster_epsilon) : far;
        }
    }
};

WEFT_NODE(NeighbourhoodsNode, "neighbourhoods", 4)

}  // namespace
}  // namespace weft
