// Plan: what a run of a graph will do, before it does it: which nodes are needed, the tasks they make
// (a value node, or a segment: a source, its stages and sinks), the order among tasks, how long
// each value lives, and the bytes that nodes say they will need.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/node.h"

namespace weft {

// A tap: a value, or the records of a stream in a rectangle of pixels, written to a file.
struct Tap {
    Link from;
    std::string text;                        // as asked for, for messages
    std::string file;
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;    // streams: pixels [x0, x1) x [y0, y1)
};

struct Task {
    bool segment = false;
    std::vector<int> nodes;       // of the graph: one, or a segment's source, stages, sinks in order
    std::vector<size_t> needs;    // tasks to be done before
    std::vector<Link> makes;      // values it makes that somebody reads
    std::vector<Link> last_uses;  // values that can go once it is done (and all earlier readers are)
    std::string name;             // the node's, or "source ... sink"
    double scratch_bytes = 0;     // while it runs
    double made_bytes = 0;        // of the values in `makes`
    double live_bytes = 0;        // of all values there are while it runs, its own included
};

struct PlanOptions {
    std::vector<std::string> taps;   // "node.port=file", "node.port@x,y=file", "node.port@x0,y0,x1,y1=file"
    int threads = 1;                 // for the scratch memory of segments
    double memory_limit = 0;         // bytes; 0: none
};

struct Plan {
    const Graph* graph = nullptr;
    std::vector<std::unique_ptr<NodeInstance>> instances;  // as graph->nodes; null: not needed
    std::vector<Task> tasks;                               // in an order that can be run one by one
    std::vector<std::vector<Shape>> shapes;                // of each node's outputs
    std::vector<std::vector<int>> readers;                 // of each output of each node: tasks that read it
    std::vector<Tap> taps;
    double peak_bytes = 0;
    size_t peak_task = 0;

    int readers_of(Link link) const;
};

// Throws Error: an input file is missing, a node cannot say its cost, the plan does not fit the limit
// (naming the task with the highest need and the numbers). A tap that names nothing throws UsageError.
struct UsageError : Error {
    using Error::Error;
};
// What a node said that makes the plan impossible, with the node's place in the document.
struct PlacedError : Error {
    PlacedError(Place at, const std::string& message) : Error(message), place(std::move(at)) {}
    Place place;
};
Plan make_plan(const Graph& graph, const PlanOptions& options = {});

// `weft plan`: tasks, segments, lifetimes, bytes, for reading; and the same for programs.
std::string to_text(const Plan& plan);
Json to_json(const Plan& plan);

// "1.5 GB", "12 MB", "640 B".
std::string bytes_text(double bytes);
// "8G", "512M", "1.5GB", "1000000"; throws UsageError.
double parse_bytes(const std::string& text);

}  // namespace weft
