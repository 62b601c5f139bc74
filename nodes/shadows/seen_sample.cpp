// seen-sample: which sample each location sees (seen_sample_kernel.h).
#include "runtime/node.h"
#include "shadows/seen_sample_kernel.h"

namespace weft {
namespace {

struct SeenSample {
    static void declare(Ports<SeenSample>& node) {
        node.about("the sample that each location sees: the nearest one of its surface")
            .in<Candidates>("candidates", "the samples near each location")
            .in<Surfaces>("surfaces", "their surfaces")
            .in<Visibility>("visibility", "the surface seen")
            .out<SeenSamples>("seen", "none where it is not decided which surface is seen");
    }
    void batch(const Inputs& in, Outputs& out) const {
        shadows::find_seen(in.get<Candidates>("candidates"), in.get<Surfaces>("surfaces"),
                           in.get<Visibility>("visibility"), out.get<SeenSamples>("seen"));
    }
};

WEFT_NODE(SeenSample, "seen-sample", 1)

}  // namespace
}  // namespace weft
