// merge-colors: puts the results of a branch back among those it was taken from.
#include <algorithm>

#include "light-field/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct MergeColors {
    static void declare(Ports<MergeColors>& node) {
        node.about("puts the colours of a branch in the places of the locations they belong to")
            .in<Colors>("colors", "of the whole batch")
            .in_branch<Colors>("branch", "of some of its locations: what is valid there counts")
            .out<Colors>("colors", "of the whole batch");
    }
    void batch(const Inputs& in, Outputs& out) const {
        const Colors &all = in.get<Colors>("colors"), &branch = in.get<Colors>("branch");
        Colors& merged = out.get<Colors>("colors");
        const size_t n = all.size();
        merged.color_space = all.color_space;
        merged.rgba.assign(all.rgba.begin(), all.rgba.begin() + std::ptrdiff_t(4 * n));
        merged.valid.assign(all.valid.begin(), all.valid.begin() + std::ptrdiff_t(n));
        for (size_t l = 0; l < branch.size(); ++l) {
            if (!branch.valid[l]) continue;
            std::copy_n(&branch.rgba[4 * l], 4, &merged.rgba[4 * size_t(branch.parents[l])]);
            merged.valid[branch.parents[l]] = 1;
        }
    }
};

WEFT_NODE(MergeColors, "merge-colors", 1)

}  // namespace
}  // namespace weft
