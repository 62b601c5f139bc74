// Runs one segment: tiles in parallel; on each worker, batch after batch through all its stages. A
// worker keeps its batches and scratch from tile to tile, so the steady state allocates nothing.
#pragma once
#include <memory>

#include "runtime/node_context.h"
#include "runtime/run.h"
#include "runtime/tap.h"
#include "runtime/values.h"

namespace weft {

// What a stage threw, and which.
struct StageError : Error {
    StageError(int n, const std::string& message) : Error(message), node(n) {}
    int node;
};

// Throws StageError or Cancelled. Values that its sinks make stand in `values` afterwards.
SegmentReport run_segment(const Plan& plan, const Task& task, Values& values, NodeContext& ctx, Monitor& monitor,
                          const RunOptions& options);

}  // namespace weft
