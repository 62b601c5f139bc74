// nearest-surface and hull-coverage: plainer answers to which surface is seen, to put in coverage's place.
//   nearest-surface   always the front one: silhouettes grow by the radius of the search
//   hull-coverage     the first whose samples' convex hull holds the location, else the last
// Both decide everything: only locations without any sample stay undecided.
#include "light-field/kernels.h"
#include "light-field/reference_kernels.h"
#include "light-field/selection.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace light_field;

template <class Node>
void declare_coverage(Ports<Node>& node, const char* about) {
    node.about(about)
        .template in<Candidates>("candidates", "the samples near each location")
        .template in<Surfaces>("surfaces", "their surfaces")
        .template in<Locations>("locations", "of the same batch, to pass on those that are not decided")
        .template out<Visibility>("visibility", "the surface seen")
        .template out_selection<Locations>("undecided", "locations without any sample");
}

// choose(l, visibility): for locations with more than one surface.
template <class Choose>
void decide(const Inputs& in, Outputs& out, Visibility& spare, Choose&& choose) {
    const Surfaces& surfaces = in.get<Surfaces>("surfaces");
    Visibility& v = out.wanted("visibility") ? out.get<Visibility>("visibility") : spare;
    const size_t n = surfaces.size();
    v.first.assign(n, 0);
    v.last.assign(n, 0);
    v.decision.assign(n, Decision::undecided);
    for (size_t l = 0; l < n; ++l) {
        if (surfaces.count_of[l] > 0) v.decision[l] = Decision::one;
        if (surfaces.count_of[l] > 1) choose(l, v);
    }
    if (out.wanted("undecided")) select(in.get<Locations>("locations"), v, Decision::undecided, out.get<Locations>("undecided"));
}

struct NearestSurface {
    static void declare(Ports<NearestSurface>& node) { declare_coverage(node, "takes the surface in front, always"); }
    using Scratch = Visibility;
    void batch(const Inputs& in, Outputs& out, Scratch& spare) const {
        decide(in, out, spare, [](size_t l, Visibility& v) { v.decision[l] = Decision::nearest; });
    }
};

struct HullCoverage {
    static void declare(Ports<HullCoverage>& node) { declare_coverage(node, "takes the first surface whose samples surround the location, else the last"); }
    struct Scratch {
        Visibility visibility;
        std::vector<float> x, y;
    };
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Candidates& c = in.get<Candidates>("candidates");
        const Surfaces& s = in.get<Surfaces>("surfaces");
        decide(in, out, scratch.visibility, [&](size_t l, Visibility& v) {
            const std::uint16_t last = std::uint16_t(s.count_of[l] - 1);
            for (std::uint16_t surface = 0; surface <= last; ++surface) {
                scratch.x.clear();
                scratch.y.clear();
                for (size_t i = c.offset[l]; i < c.offset[l + 1]; ++i)
                    if (s.surface[i] == surface) {
                        scratch.x.push_back(c.dx[i]);
                        scratch.y.push_back(c.dy[i]);
                    }
                if (surface < last && !reference::hull_holds_origin(scratch.x, scratch.y)) continue;
                v.first[l] = v.last[l] = surface;
                v.decision[l] = surface < last ? Decision::covered : Decision::last;
                return;
            }
        });
    }
};

WEFT_NODE(NearestSurface, "nearest-surface", 1)
WEFT_NODE(HullCoverage, "hull-coverage", 1)

}  // namespace
}  // namespace weft
