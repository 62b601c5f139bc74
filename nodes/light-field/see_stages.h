// What the fusions of reproject, same-surface-cluster, coverage and filter-visible share: their
// ports and parameters, and how a batch goes through the kernel that stands for them.
#pragma once
#include <algorithm>

#include "light-field/kernels.h"
#include "light-field/local_radius.h"
#include "light-field/projected.h"
#include "light-field/selection.h"
#include "runtime/fusion.h"

namespace weft::light_field {

enum class Pass { first, final };  // of coverage

struct SeeStages {
    float search = 1, reach = 2, tent = 1, exponent = 2, box = 0, tolerance = 0, view_test = 0;
    Pass pass = Pass::first;

    // `Node` is a SeeStages; `more`: further readers of candidates, surfaces and visibility.
    template <class Node>
    static Fusing<Node>& declare_stages(Fusing<Node>& fusing,
                                        const std::vector<std::string>& more = {}) {
        for (const char* part : {"reproject", "same-surface-cluster", "coverage", "filter-visible"})
            fusing.part(part);
        for (const std::string& part : more) fusing.part(part);
        const auto readers = [&](const std::string& port, std::vector<std::string> of) {
            of.insert(of.end(), more.begin(), more.end());
            for (std::string& part : of) part += "." + port;
            return of;
        };
        const auto number = [&](const char* name, float SeeStages::*field) {
            fusing.param(name, static_cast<float Node::*>(field));
        };
        fusing
            .inner("reproject.candidates",
                   readers("candidates", {"same-surface-cluster", "coverage", "filter-visible"}))
            .inner("same-surface-cluster.surfaces",
                   readers("surfaces", {"coverage", "filter-visible"}))
            .inner("coverage.visibility", readers("visibility", {"filter-visible"}))
            .in("locations", {"reproject.locations", "coverage.locations"})
            .in("hierarchy", {"reproject.hierarchy"})
            .in("projection", {"reproject.projection"})
            .out("projection", "reproject.projection")
            .out("undecided", "coverage.undecided")
            .out("colors", "filter-visible.colors")
            .param("coverage.pass", static_cast<Pass Node::*>(&SeeStages::pass));
        number("reproject.radius-scale", &SeeStages::search);
        number("reproject.reach", &SeeStages::reach);
        number("same-surface-cluster.box", &SeeStages::box);
        number("same-surface-cluster.tolerance", &SeeStages::tolerance);
        number("filter-visible.radius-scale", &SeeStages::tent);
        number("filter-visible.exponent", &SeeStages::exponent);
        number("filter-visible.view-test", &SeeStages::view_test);
        return fusing;
    }

    // The kernel has these powers only, and takes for granted that the tent ends within the search.
    bool suits() const {
        return (exponent == 1 || exponent == 2 || exponent == 4) && tent <= search &&
               view_test == 0;
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

    // One batch. `nearest`, if wanted, gets the sample that each location sees (kernels.h); where
    // the batch had to go stage by stage it is not touched, and the result is false.
    bool see_batch(const Inputs& in, Outputs& out, Scratch& scratch,
                   std::vector<std::uint32_t>* nearest = nullptr) const {
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        const Locations& at = in.get<Locations>("locations");
        h.require_colors();
        const float largest = largest_radius(h, at), radius = search * largest;
        const SeeSettings set{
            radius, h.radius, {box, tolerance}, {tent * h.radius, exponent}, pass == Pass::final};
        Projection* made = out.wanted("projection") ? &out.get<Projection>("projection") : nullptr;
        Colors& colors = out.wanted("colors") ? out.get<Colors>("colors") : scratch.unread;
        const Projection* p = nullptr;
        if (at.shared)
            p = &projected(h, at, radius, std::max(reach, search) * largest, !set.final,
                           in.find<Projection>("projection"), made, scratch.projected);
        else if (made)
            made->hierarchy = nullptr, made->samples = 0;
        const bool whole = p && h.radii.empty() && at.ratio.empty();
        if (whole) {
            if (nearest) nearest->resize(at.size());
            WEFT_PICK(see)
            (*p, at, set, scratch.see, colors, nearest ? nearest->data() : nullptr);
        } else {
            one_by_one(h, p, at, set, scratch, colors);
        }
        if (out.wanted("undecided"))
            select(at, scratch.see.visibility, Decision::undecided,
                   out.get<Locations>("undecided"));
        return whole;
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

}  // namespace weft::light_field
