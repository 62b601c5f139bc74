// The commands of the program. Each takes plain options and gives an exit status:
// 0 done; 1 a node failed, an input is missing or damaged, or the plan does not fit;
// 2 the graph document or the command line is wrong; 130 interrupted.
#pragma once
#include <string>
#include <vector>

#include "graph/graph.h"

namespace weft::cli {

enum Status { done = 0, failed = 1, misused = 2, interrupted = 130 };

struct GraphOptions {
    std::string graph;
    Overrides overrides;
};

struct RunCommand : GraphOptions {
    int threads = 0;       // 0: one a core
    int tile = 32;
    std::string memory;    // "8G"
    std::string report, trace;
    std::vector<std::string> taps;
    bool no_fuse = false;
    std::string isa;
    std::string executor = "tbb";
    bool quiet = false;
    std::string shard;                // "2/5"; "": all of it
    std::vector<std::string> divide;  // nodes
    std::string part, expect;         // where the shard goes; a farm's job to be held to
};
int run(const RunCommand& options);

struct MergeCommand {
    std::string out;
    std::vector<std::string> parts;
    std::vector<std::string> set;
    int threads = 0;
    std::string memory, report, trace;
    bool quiet = false;
};
int merge(const MergeCommand& options);

struct FarmCommand : GraphOptions {
    int shards = 0;
    std::string engine = "slurm", folder, isa, memory, partition;
    std::vector<std::string> divide, slurm, nodes;  // nodes: --nodes
    int tile = 32, threads = 0, at_once = 0;
    bool dry_run = false, resume = false, follow = false, quiet = false;
};
int farm(const FarmCommand& options);

struct CheckCommand {
    std::vector<std::string> graphs;
    Overrides overrides;
    bool json = false;
};
int check(const CheckCommand& options);

struct PlanCommand : GraphOptions {
    int threads = 0;
    std::string memory;
    std::vector<std::string> taps;
    bool no_fuse = false;
    bool json = false;
};
int plan(const PlanCommand& options);

int dot(const GraphOptions& options, bool mermaid);

int nodes(const std::string& family, bool json);
int node(const std::string& type, bool json);
int schema();

int compare(const std::string& picture, const std::string& reference, const std::string& error_picture, bool json);
int show(const std::string& file, bool json);

}  // namespace weft::cli
