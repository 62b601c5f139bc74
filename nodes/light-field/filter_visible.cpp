// filter-visible: the radiance of each location, filtered from the samples of the surface seen: weight
// (1 - d / radius)^exponent at screen distance d; where all weights vanish the nearest sample's.
// Source: Lehtinen et al. 2011, Sec. 3.5.  Departure: the tent is squared by default (theirs: exponent 1),
// which blurs less; noise is smooth-radiance's business.
#include "light-field/kernels.h"
#include "light-field/view_filter.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace light_field;

struct FilterVisible {
    float radius_scale = 1, exponent = 2, view_test = 0;

    static void declare(Ports<FilterVisible>& node) {
        node.about("filters the samples of the surface seen with a tent")
            .in<Candidates>("candidates", "the samples near each location")
            .in<Surfaces>("surfaces", "their surfaces")
            .in<Visibility>("visibility", "the surface seen")
            .out<Colors>("colors", "radiance of each location that is decided")
            .param("radius-scale", &FilterVisible::radius_scale, {.unit = "R", .min = 0.05, .max = 32, .about = "where the tent ends"})
            .param("exponent", &FilterVisible::exponent, {.min = 0.25, .max = 16, .about = "the tent is raised to this power: more is narrower"})
            .param("view-test", &FilterVisible::view_test,
                   {.min = 0, .max = 1e6, .about = "F beyond which samples that differ over lens and time are read at the location's own (u, v, t), not averaged: for gloss and mirrors, many times slower; 0: never"});
    }
    using Scratch = FilterScratch;
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Candidates& c = in.get<Candidates>("candidates");
        c.hierarchy->require_colors();
        const Tent tent{radius_scale * c.hierarchy->radius, exponent};
        if (view_test > 0) return filter_by_view(c, in.get<Surfaces>("surfaces"), in.get<Visibility>("visibility"), tent, view_test, out.get<Colors>("colors"));
        WEFT_PICK(filter)(c, in.get<Surfaces>("surfaces"), in.get<Visibility>("visibility"),
                          tent, scratch, out.get<Colors>("colors"));
    }
};

WEFT_NODE(FilterVisible, "filter-visible", 1)

}  // namespace
}  // namespace weft
