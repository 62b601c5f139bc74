// same-surface-cluster: tells apart the surfaces among a location's candidates. Front to back, a sample
// whose trajectory crosses that of one of the open surface near the location begins the next.
// Source: Lehtinen et al. 2011, Sec. 3.3.  Departure: pairs of samples are compared, as the paper has it and
// its published code does not (it compares bounds of tree leaves).
#include "light-field/kernels.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace light_field;

struct SameSurfaceCluster {
    float tolerance = 0.1f, box = 0.0884f;

    static void declare(Ports<SameSurfaceCluster>& node) {
        node.about("groups candidates into surfaces: samples whose trajectories cross near the location are of different ones")
            .in<Candidates>("candidates", "the samples near each location")
            .out<Surfaces>("surfaces", "a surface for each candidate, 0 the nearest")
            .param("tolerance", &SameSurfaceCluster::tolerance, {.unit = "px", .min = 1e-4, .max = 10, .about = "crossings by less are let pass"})
            .param("box", &SameSurfaceCluster::box,
                   {.min = 0, .max = 4, .about = "how far from the location's (u, v) trajectories are followed; in time half as far"});
    }
    using Scratch = ClusterScratch;
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        WEFT_PICK(cluster)(in.get<Candidates>("candidates"), SameSurface{box, tolerance}, scratch, out.get<Surfaces>("surfaces"));
    }
};

WEFT_NODE(SameSurfaceCluster, "same-surface-cluster", 1)

}  // namespace
}  // namespace weft
