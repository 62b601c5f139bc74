// Plan: what a run of a graph will do, before it does it: which nodes are needed, the tasks they make
// (a value node, or a segment: a source, its stages and sinks), the order among tasks, how long
// each value lives, and the bytes that nodes say they will need.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/node.h"
#include "runtime/stage.h"

namespace weft {

// A tap: a value, or the records of a stream in a rectangle of pixels, written to a file.
struct Tap {
    Link from;
    std::string text;                        // as asked for, for messages
    std::string file;
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;    // streams: pixels [x0, x1) x [y0, y1)
};

// Which part of a graph's work a plan is for. A shard does its tiles and pieces of the divided tasks, and all
// that comes before; the merge takes these in and does all that comes after.
enum class Work { whole, shard, merge };

struct Task {
    bool segment = false;
    bool divided = false;         // in a plan for a shard or for the merge
    std::vector<int> nodes;       // of the graph: one, or a segment's source, stages, sinks in order
    std::vector<StagePlan> stages;  // of a segment: the same, neighbours that a fusion stands for taken together
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
    bool fuse = true;                // let fusions stand for the stages they match
    Work work = Work::whole;
    std::vector<std::string> divide;       // nodes whose tasks are divided; none: the last that can be
    std::map<std::string, Shape> shapes;   // of outputs ("node.port") of nodes that are not planned: the merge's
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
    Work work = Work::whole;

    int readers_of(Link link) const;
    std::string name_of(Link link) const;  // "node.port"
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

// Which tasks of a whole plan a shard would divide (runtime/divide.cpp). A segment can be divided, and a value
// node that makes its result in pieces; of those that wait for each other the last. Throws UsageError
// if there is none, if one of its sinks cannot hand out its tiles, or if `nodes` names others.
std::vector<size_t> divided_tasks(const Plan& plan, const std::vector<std::string>& nodes);

// `weft plan`: tasks, segments, lifetimes, bytes, keys if there are, for reading; and the same for programs.
struct Keys;
std::string to_text(const Plan& plan, const Keys* keys = nullptr);
Json to_json(const Plan& plan, const Keys* keys = nullptr);

// "1.5 GB", "12 MB", "640 B".
std::string bytes_text(double bytes);
// "8G", "512M", "1.5GB", "1000000"; throws UsageError.
double parse_bytes(const std::string& text);

}  // namespace weft
