// Runs a plan: ready tasks at once, segments tile by tile, values freed after their last reader.
#pragma once
#include <atomic>
#include <map>
#include <string>
#include <vector>

#include "runtime/executor.h"
#include "runtime/monitor.h"
#include "runtime/part_file.h"
#include "runtime/plan.h"

namespace weft {

struct RunOptions {
    int tile = 32;                              // pixels a side; changes no result
    Provenance provenance;
    const std::atomic<bool>* stop = nullptr;    // set by somebody: end soon, leave no partial file
    Shard shard;                                // of a plan for a shard ...
    PartWriter* part = nullptr;                 // ... and where its tiles and pieces go
    const Parts* parts = nullptr;               // of a plan for the merge: where they come from
};

struct NodeError {
    std::string node;
    Place place;
    std::string message;               // with the node's inputs
    std::vector<std::string> skipped;  // what could not run because of it
};

struct StageReport {
    std::string name, type;
    double cpu_s = 0, wall_s = 0;
    std::map<std::string, std::uint64_t> items;
};
struct SegmentReport {
    std::string name;
    double wall_s = 0;
    size_t tiles = 0;
    std::vector<StageReport> stages;
};

struct RunResult {
    std::vector<NodeError> errors;
    bool cancelled = false;
    std::vector<StageReport> nodes;        // value nodes
    std::vector<SegmentReport> segments;
    double wall_s = 0, cpu_s = 0;
    std::vector<DividedTask> divided;      // of a shard, as its part's header lists them
    double peak_bytes = 0;                 // resident, of the process
    bool ok() const { return errors.empty() && !cancelled; }
};

RunResult run_plan(const Plan& plan, Executor& executor, Monitor& monitor, const RunOptions& options = {});

// The report of --report (docs/report.md), one JSON text.
std::string report_json(const RunResult& result, const Plan& plan, int threads);

}  // namespace weft
