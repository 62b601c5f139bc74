// see-visible-sample: see-visible (light-field/see_visible.cpp) and seen-sample together: while a
// surface is filtered, which of its samples is nearest comes for little more.
#include "light-field/see_stages.h"
#include "shadows/seen_sample_kernel.h"

namespace weft {
namespace {

struct SeeVisibleSample : light_field::SeeStages {
    static void declare(Fusing<SeeVisibleSample>& fusing) {
        declare_stages(fusing, {"seen-sample"})
            .about(
                "finds the samples near each location, tells their surfaces apart, filters the one "
                "that is seen and finds its nearest sample")
            .out("seen", "seen-sample.seen");
    }
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        SeenSamples& seen = out.get<SeenSamples>("seen");
        if (!see_batch(in, out, scratch, &seen.sample))
            shadows::find_seen(scratch.candidates, scratch.surfaces, scratch.see.visibility, seen);
    }
};

WEFT_FUSION(SeeVisibleSample, "see-visible-sample")

}  // namespace
}  // namespace weft
