// reproject-nearest: the k samples that land nearest to each location, instead of all within a radius: an
// even number of candidates where samples fan out or crowd.
#include <algorithm>

#include "light-field/kernels.h"
#include "light-field/local_radius.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace light_field;

struct ReprojectNearest {
    int count = 12;
    float radius_scale = 2;

    static void declare(Ports<ReprojectNearest>& node) {
        node.about("the nearest few samples of each location, at its lens position and time")
            .in<Locations>("locations", "points to serve")
            .in<Hierarchy>("hierarchy", "the samples")
            .in<Projection>("projection", "not looked at; so that it fits in reproject's place", Need::optional)
            .out<Candidates>("candidates", "the samples near each location")
            .out<Projection>("projection", "empty: others have to project for themselves")
            .param("count", &ReprojectNearest::count, {.min = 1, .max = 4096, .about = "candidates a location"})
            .param("radius-scale", &ReprojectNearest::radius_scale, {.unit = "R", .min = 0.05, .max = 32, .about = "none farther than this"});
    }
    struct Scratch {
        Block block;
        Candidates all;
        std::vector<std::pair<float, std::uint32_t>> order;
    };
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        const Locations& at = in.get<Locations>("locations");
        const float radius = radius_scale * largest_radius(h, at);
        if (!scratch.block.covers(h, at.x0, at.y0, at.x1, at.y1, radius)) collect(h, at.x0, at.y0, at.x1, at.y1, radius, scratch.block);
        Candidates& all = scratch.all;
        all.pixels = at.pixels;
        WEFT_PICK(gather_each)(h, scratch.block, at, radius, all);
        narrow(radius_scale, at, all);
        if (out.wanted("projection")) out.get<Projection>("projection").hierarchy = nullptr;
        Candidates& c = out.get<Candidates>("candidates");
        c.hierarchy = &h;
        c.radius = radius;
        c.shared = all.shared;
        c.x = all.x, c.y = all.y, c.u = all.u, c.v = all.v, c.t = all.t;
        c.spread = all.spread;
        c.ratio = all.ratio;
        c.slope_step = all.slope_step;
        c.velocity_step = all.velocity_step;
        c.offset.assign(1, 0);
        const size_t most = all.offset[at.size()] + Projection::padding;  // kernels read whole vectors
        c.dx.resize(most);
        c.dy.resize(most);
        c.sample.resize(most);
        for (size_t l = 0; l < at.size(); ++l) {
            scratch.order.clear();
            for (std::uint32_t i = all.offset[l]; i < all.offset[l + 1]; ++i)
                scratch.order.emplace_back(all.dx[i] * all.dx[i] + all.dy[i] * all.dy[i], i);
            const size_t keep = std::min(scratch.order.size(), size_t(count));
            std::partial_sort(scratch.order.begin(), scratch.order.begin() + std::ptrdiff_t(keep), scratch.order.end());
            std::uint32_t to = c.offset[l];
            for (size_t k = 0; k < keep; ++k, ++to) {
                const std::uint32_t i = scratch.order[k].second;
                c.dx[to] = all.dx[i];
                c.dy[to] = all.dy[i];
                c.sample[to] = all.sample[i];
            }
            c.offset.push_back(to);
        }
    }
};

WEFT_NODE(ReprojectNearest, "reproject-nearest", 1)

}  // namespace
}  // namespace weft
