// Runs one segment: tiles in parallel; on each worker, batch after batch through all its stages. A
// worker keeps its batches and scratch from tile to tile, so the steady state allocates nothing.
#pragma once
#include <memory>
#include <new>

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

// Puts the node on what `work` throws.
template <class Work>
void guarded(int node, Work&& work) {
    try {
        work();
    } catch (const StageError&) {
        throw;
    } catch (const Cancelled&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw StageError(node, "ran out of memory");
    } catch (const std::exception& error) {
        throw StageError(node, error.what());
    }
}

// The tiles of an extent, row by row.
struct TileGrid {
    TileGrid(const Extent& of, int tile);
    size_t size() const { return across * down; }
    Tile tile(size_t index) const;

    Extent extent;
    int side;
    size_t across, down;
};

// Throws StageError or Cancelled. Values that its sinks make stand in `values` afterwards. For a shard
// (options.part): only its tiles are made and handed to the part, as those of its task `index`; `made` says then
// what they are of.
SegmentReport run_segment(const Plan& plan, const Task& task, Values& values, NodeContext& ctx, Monitor& monitor,
                          const RunOptions& options, DividedTask* made = nullptr, std::uint32_t index = 0);

// A divided value node, in a shard (runtime/join.cpp).
void run_pieces(const Plan& plan, const Task& task, Values& values, NodeContext& ctx, const RunOptions& options, DividedTask& made,
                std::uint32_t index);
// A divided task in the merge: what the shards made becomes its values. Throws StageError or Cancelled.
void join_task(const Plan& plan, const Task& task, Values& values, NodeContext& ctx, const RunOptions& options);

}  // namespace weft
