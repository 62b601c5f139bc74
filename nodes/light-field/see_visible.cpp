// see-visible: reproject, same-surface-cluster, coverage and filter-visible as one kernel, in which
// a location's candidates never leave the cache of its core; most have one surface and are filtered
// while they are found.
#include <algorithm>

#include "light-field/kernels.h"
#include "light-field/local_radius.h"
#include "light-field/projected.h"
#include "light-field/selection.h"
#include "runtime/fusion.h"

namespace weft {
namespace {
using namespace light_field;

enum class Pass { first, final };  // of coverage

struct SeeVisible {
    float search = 1, reach = 2, tent = 1, exponent = 2, box = 0, tolerance = 0, view_test = 0;
    Pass pass = Pass::first;

    static void declare(Fusing<SeeVisible>& fusing) {
        fusing
            .about(
                "finds the samples near each location, tells their surfaces apart and filters the "
                "one that is seen")
            .part("reproject")
            .part("same-surface-cluster")
            .part("coverage")
            .part("filter-visible")
            .inner("reproject.candidates", {"same-surface-cluster.candidates",
                                            "coverage.candidates", "filter-visible.candidates"})
            .inner("same-surface-cluster.surfaces",
                   {"coverage.surfaces", "filter-visible.surfaces"})
            .inner("coverage.visibility", {"filter-visible.visibility"})
            .in("locations", {"reproject.locations", "coverage.locations"})
            .in("hierarchy", {"reproject.hierarchy"})
            .in("projection", {"reproject.projection"})
            .out("projection", "reproject.projection")
            .out("undecided", "coverage.undecided")
            .out("colors", "filter-visible.colors")
            .param("reproject.radius-scale", &SeeVisible::search)
            .param("reproject.reach", &SeeVisible::reach)
            .param("same-surface-cluster.box", &SeeVisible::box)
            .param("same-surface-cluster.tolerance", &SeeVisible::tolerance)
            .param("coverage.pass", &SeeVisible::pass)
            .param("filter-visible.radius-scale", &SeeVisible::tent)
            .param("filter-visible.exponent", &SeeVisible::exponent)
            .param("filter-visible.view-test", &SeeVisible::view_test);
    }

    // The kernel has these powers only, and takes for granted that the tent ends within the search.
    bool suits() const {
        return (exponent == 1 || exponent == 2 || exponent == 4) && tent <= search && view_test == 0;
    }

    struct Scratch {
        ProjectedScratch projected;
        SeeScratch see;
        Colors unread;
        // For batches that go stage by stage.
        Candidates candidates;
        Surfaces surfaces;
        ClusterScratch cluster;
        FilterScratch filter;
    };

    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        const Locations& at = in.get<Locations>("locations");
        h.require_colors();
        const float largest = largest_radius(h, at),
                    radius = search * largest;
        const SeeSettings set{
            radius, h.radius, {box, tolerance}, {tent * h.radius, exponent}, pass == Pass::final};
        Projection* made = out.wanted("projection") ? &out.get<Projection>("projection") : nullptr;
        Colors& colors = out.wanted("colors") ? out.get<Colors>("colors") : scratch.unread;
        const Projection* p = nullptr;
        if (at.shared)
            p = &projected(h, at, radius, std::max(reach, search) * largest, !set.final,
                           in.find<Projection>("projection"), made, scratch.projected);
        else if (made)
            made->hierarchy = nullptr;
        if (p && h.radii.empty() && at.ratio.empty())
            WEFT_PICK(see)(*p, at, set, scratch.see, colors);
        else
            one_by_one(h, p, at, set, scratch, colors);
        if (out.wanted("undecided"))
            select(at, scratch.see.visibility, Decision::undecided,
                   out.get<Locations>("undecided"));
    }

  private:
    // A batch without a common (u, v, t), or with radii that vary: stage by stage.
    void one_by_one(const Hierarchy& h, const Projection* projection, const Locations& at,
                    const SeeSettings& set, Scratch& s, Colors& colors) const {
        for (Batch* batch :
             std::initializer_list<Batch*>{&s.candidates, &s.surfaces, &s.see.visibility}) {
            batch->pixels = at.pixels;
            batch->parents = at.parents;
        }
        if (projection) {
            WEFT_PICK(gather)(*projection, at, set.radius, s.candidates);
        } else {
            collect_for(h, at, set.radius, s.projected.block);
            WEFT_PICK(gather_each)(h, s.projected.block, at, set.radius, s.candidates);
        }
        narrow(search, at, s.candidates);
        WEFT_PICK(cluster)(s.candidates, set.test, s.cluster, s.surfaces);
        if (set.final) WEFT_PICK(cover_finally)
        (s.candidates, s.surfaces, set.cover_radius, s.see.coverage, s.see.visibility);
        else WEFT_PICK(cover)(s.candidates, s.surfaces, set.cover_radius, s.see.visibility);
        WEFT_PICK(filter)(s.candidates, s.surfaces, s.see.visibility, set.tent, s.filter, colors);
        colors.candidates = s.candidates.offset[at.size()];
    }
};

WEFT_FUSION(SeeVisible, "see-visible")

}  // namespace
}  // namespace weft
