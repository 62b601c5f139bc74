// What run, merge and a farm's shards have in common: options of a run, from a graph to an exit
// status.
#pragma once
#include <memory>
#include <string>

#include "cli/commands.h"
#include "runtime/executor.h"
#include "runtime/plan.h"
#include "runtime/run.h"

namespace weft::cli {

std::unique_ptr<Executor> executor_named(const std::string& name, int threads);
void pin_isa_named(const std::string& isa);  // "": leaves it

// The graph that an option names: a document, or a picture that Weft wrote.
Loaded load_for_run(const std::string& graph, const Overrides& overrides);
// The name that a shard's part gets where none is given: "out/tlfr.shard-2-of-5.part".
std::string part_name(const Graph& graph, const Shard& shard);
// Text of a graph parameter that names a file, or "".
std::string file_parameter(const Graph& graph, const std::string& name);

// The graph parameter that a merge's OUT stands for: 'out', or the only one that names a file to
// write.
std::string parameter_of_out(const PartHeader& header);

struct ExecuteOptions {
    bool quiet = false;
    std::string report, trace;
};
// Runs with progress; prints errors. After it: reports and traces are written, `result` is filled.
Status execute(const Plan& plan, Executor& executor, RunOptions run, const ExecuteOptions& options,
               RunResult& result);

}  // namespace weft::cli
