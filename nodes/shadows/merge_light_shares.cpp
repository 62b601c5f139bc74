// merge-light-shares: puts the light shares of a branch back among those it was taken from.
#include <algorithm>

#include "runtime/node.h"
#include "shadows/streams.h"

namespace weft {
namespace {

struct MergeLightShares {
    static void declare(Ports<MergeLightShares>& node) {
        node.about(
                "puts the light shares of a branch in the places of the locations they belong to")
            .in<LightShares>("shares", "of the whole batch")
            .in_branch<LightShares>("branch",
                                    "of some of its locations: where anybody voted it counts")
            .out<LightShares>("shares", "of the whole batch");
    }
    void batch(const Inputs& in, Outputs& out) const {
        const LightShares &all = in.get<LightShares>("shares"),
                          &branch = in.get<LightShares>("branch");
        LightShares& merged = out.get<LightShares>("shares");
        const auto n = std::ptrdiff_t(all.size());
        merged.share.assign(all.share.begin(), all.share.begin() + n);
        merged.votes.assign(all.votes.begin(), all.votes.begin() + n);
        for (size_t l = 0; l < branch.size(); ++l) {
            if (branch.votes[l] == 0) continue;
            merged.share[branch.parents[l]] = branch.share[l];
            merged.votes[branch.parents[l]] = branch.votes[l];
        }
    }
};

WEFT_NODE(MergeLightShares, "merge-light-shares", 1)

}  // namespace
}  // namespace weft
