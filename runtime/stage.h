// StagePlan: one step of a segment: a node, or several whose work a fusion does.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "runtime/fusion.h"

namespace weft {

struct StagePlan {
    // A port of the step: whose it is, and what the step calls it.
    struct Port {
        std::string name;
        int node = -1, port = -1;  // of the graph: an input, or an output
    };
    std::vector<int> nodes;               // of the graph, in order
    const FusionType* fusion = nullptr;   // of several
    std::unique_ptr<NodeInstance> fused;  // the fusion's; a single node's stands in the plan
    std::vector<Port> inputs, outputs;

    // "reproject+surfaces" of nodes, "retry/reproject+surfaces" where they are parts of one node.
    std::string name(const Graph& graph) const;
    const std::string& type(const Graph& graph) const;
};

// The steps of a segment's nodes. A stream that `tapped` says yes to, and what nodes that are not
// `needed` read, is nobody's inside. Without `fuse` each node is a step of its own.
std::vector<StagePlan> stages_of(const Graph& graph, const std::vector<int>& nodes, bool fuse,
                                 const std::function<bool(Link)>& tapped);

}  // namespace weft
