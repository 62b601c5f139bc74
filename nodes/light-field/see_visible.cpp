// see-visible: reproject, same-surface-cluster, coverage and filter-visible as one kernel, in which
// a location's candidates never leave the cache of its core; most have one surface and are filtered
// while they are found.
#include "light-field/see_stages.h"

namespace weft {
namespace {

struct SeeVisible : light_field::SeeStages {
    static void declare(Fusing<SeeVisible>& fusing) {
        declare_stages(fusing).about(
            "finds the samples near each location, tells their surfaces apart and filters the one "
            "that is seen");
    }
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        see_batch(in, out, scratch);
    }
};

WEFT_FUSION(SeeVisible, "see-visible")

}  // namespace
}  // namespace weft
