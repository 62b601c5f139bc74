// merge-seen: puts what a branch of locations sees back among those it was taken from.
#include <algorithm>

#include "runtime/node.h"
#include "shadows/streams.h"

namespace weft {
namespace {

struct MergeSeen {
    static void declare(Ports<MergeSeen>& node) {
        node.about(
                "puts the samples that a branch sees in the places of the locations they belong to")
            .in<SeenSamples>("seen", "of the whole batch")
            .in_branch<SeenSamples>("branch", "of some of its locations: what is there counts")
            .out<SeenSamples>("seen", "of the whole batch");
    }
    void batch(const Inputs& in, Outputs& out) const {
        const SeenSamples &all = in.get<SeenSamples>("seen"),
                          &branch = in.get<SeenSamples>("branch");
        SeenSamples& merged = out.get<SeenSamples>("seen");
        merged.sample.assign(all.sample.begin(), all.sample.begin() + std::ptrdiff_t(all.size()));
        for (size_t l = 0; l < branch.size(); ++l)
            if (branch.sample[l] != SeenSamples::none)
                merged.sample[branch.parents[l]] = branch.sample[l];
    }
};

WEFT_NODE(MergeSeen, "merge-seen", 1)

}  // namespace
}  // namespace weft
