// A graph as a function of points: a document with an input "points" and an output "samples", both
// Samples. What does not read the points is made once.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/node.h"
#include "samples/samples.h"

namespace weft::adaptive {

class GraphFunction {
  public:
    // `set`: parameters of the document. Throws Error with every finding, or what a node said.
    GraphFunction(const std::string& file, const Json& set, Context& ctx);

    // Threads: pure, as far as the graph's nodes are.
    Samples operator()(const Samples& points) const;

  private:
    using Values = std::vector<std::vector<std::shared_ptr<void>>>;  // of each output of each node
    void run(size_t node, Values& values, Context& ctx) const;

    Graph graph_;
    std::vector<std::unique_ptr<NodeInstance>> instances_;
    std::vector<bool> asked_;  // reads the points, by whatever way
    size_t points_ = 0;        // the node that stands for them
    Link output_;
    Values constant_;
};

}  // namespace weft::adaptive
