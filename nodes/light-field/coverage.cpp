// coverage: which surface is seen. First pass: where there is one, or the front one surrounds the location,
// that is it; other locations go to `undecided`, to be tried again with samples from farther around.
// Final pass: front to back, the first surface of which a small triangle holds the location, else the last; and before
// it those too thin for that, each by the part of the location that it covers.
// Source: Lehtinen et al. 2011, Sec. 3.4.  Departure: the first pass asks whether the hull of all samples
// holds the location, and not for one in each quadrant (a stricter test, and exact). Thin surfaces (kernels.h) are
// transparent by their samples' density, so that small things keep their light; theirs merges a surface of fewer than
// four samples into the next.
#include "light-field/kernels.h"
#include "light-field/selection.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace light_field;

enum class Pass { first, final };

struct Coverage {
    Pass pass = Pass::first;

    static void declare(Ports<Coverage>& node) {
        node.about("decides which surface is seen from each location")
            .in<Candidates>("candidates", "the samples near each location")
            .in<Surfaces>("surfaces", "their surfaces")
            .in<Locations>("locations", "of the same batch, to pass on those that are not decided")
            .out<Visibility>("visibility", "the surface seen")
            .out_selection<Locations>("undecided", "first pass: where more samples are needed; final: where there are none")
            .choice("pass", &Coverage::pass, {"first", "final"}, {.about = "whether to leave doubtful locations undecided, or to settle all"});
    }
    using Scratch = CoverageScratch;
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Candidates& candidates = in.get<Candidates>("candidates");
        const Surfaces& surfaces = in.get<Surfaces>("surfaces");
        Visibility& visibility = out.wanted("visibility") ? out.get<Visibility>("visibility") : scratch.visibility;
        if (pass == Pass::first) WEFT_PICK(cover)(candidates, surfaces, candidates.hierarchy->radius, visibility);
        else WEFT_PICK(cover_finally)(candidates, surfaces, candidates.hierarchy->radius, scratch, visibility);
        if (out.wanted("undecided"))
            select(in.get<Locations>("locations"), visibility, Decision::undecided, out.get<Locations>("undecided"));
    }
};

WEFT_NODE(Coverage, "coverage", 2)

}  // namespace
}  // namespace weft
