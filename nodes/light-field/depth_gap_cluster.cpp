// depth-gap-cluster: surfaces by gaps in depth alone, measured where they matter, in slope over the lens:
// a step of more than `gap` px between one sample and the next in depth begins a new surface.
#include <algorithm>

#include "light-field/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct DepthGapCluster {
    float gap = 1;

    static void declare(Ports<DepthGapCluster>& node) {
        node.about("groups candidates into surfaces at gaps in depth")
            .in<Candidates>("candidates", "the samples near each location")
            .out<Surfaces>("surfaces", "a surface for each candidate, 0 the nearest")
            .param("gap", &DepthGapCluster::gap, {.unit = "px", .min = 0, .max = 1e3, .about = "difference in slope over the lens that parts two surfaces"});
    }
    struct Scratch {
        std::vector<std::pair<float, std::uint32_t>> depth;
        std::vector<float> slope;
    };
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Candidates& c = in.get<Candidates>("candidates");
        Surfaces& s = out.get<Surfaces>("surfaces");
        s.count_of.resize(c.size());
        s.surface.resize(c.offset[c.size()] + 16);  // kernels read whole vectors
        for (size_t l = 0; l < c.size(); ++l) {
            const size_t n = c.of(l);
            scratch.depth.resize(n);
            scratch.slope.resize(n);
            for (size_t k = 0; k < n; ++k) {
                const Trajectory path = c.trajectory(l, k);
                scratch.depth[k] = {path.depth, std::uint32_t(k)};
                scratch.slope[k] = path.slope_y;
            }
            std::sort(scratch.depth.begin(), scratch.depth.end());
            std::uint16_t surface = 0;
            for (size_t i = 0; i < n; ++i) {
                const size_t k = scratch.depth[i].second;
                if (i > 0 && std::abs(scratch.slope[k] - scratch.slope[scratch.depth[i - 1].second]) > gap) ++surface;
                s.surface[c.offset[l] + k] = surface;
            }
            s.count_of[l] = n ? std::uint16_t(surface + 1) : 0;
        }
    }
};

WEFT_NODE(DepthGapCluster, "depth-gap-cluster", 1)

}  // namespace
}  // namespace weft
