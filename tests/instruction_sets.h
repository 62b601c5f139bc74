// The instruction sets of this processor, and how a test pins one.
#pragma once
#include <vector>

#include "runtime/isa.h"

namespace weft {

inline std::vector<Isa> instruction_sets() {
    std::vector<Isa> all;
    for (Isa isa : {Isa::v2, Isa::v3, Isa::v4})
        if (isa <= best_isa()) all.push_back(isa);
    return all;
}
// Runs kernels on one instruction set while it lives.
struct PinnedIsa {
    explicit PinnedIsa(Isa isa) : before(active_isa()) { pin_isa(isa); }
    ~PinnedIsa() { pin_isa(before); }
    Isa before;
};

}  // namespace weft
