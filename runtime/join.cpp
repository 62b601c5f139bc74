// Divided tasks: a value node's pieces in a shard, and both kinds of divided task in the merge.
#include <fmt/format.h>

#include <algorithm>
#include <mutex>

#include "runtime/segment.h"

namespace weft {
namespace {

// Inputs with every port there and nothing in it.
Inputs empty_inputs(const GraphNode& node, const Extent& extent) {
    Inputs in;
    for (const PortDecl& port : node.type->inputs) {
        Slot slot;
        slot.port = port.name;
        slot.type = Registry::instance().type_info(port.type);
        in.slots.push_back(std::move(slot));
    }
    in.extent_ = extent;
    return in;
}

// The task's place in the parts, by the name of its first node.
std::uint32_t index_in(const Parts& parts, const std::string& node) {
    const std::vector<DividedTask>& tasks = parts.header().tasks;
    for (size_t i = 0; i < tasks.size(); ++i)
        if (tasks[i].node == node) return std::uint32_t(i);
    throw Error(fmt::format("the parts hold nothing of '{}'", node));
}

class PartPieces final : public Pieces {
  public:
    PartPieces(const Parts& parts, std::uint32_t task) : parts_(parts), task_(task) {}
    size_t size() const override { return parts_.header().tasks[task_].items; }
    ByteReader read(size_t index) const override { return parts_.read(task_, 0, index); }

  private:
    const Parts& parts_;
    std::uint32_t task_;
};

// One sink of a segment: its tiles in, its value out.
void join_sink(const Plan& plan, int node, Values& values, NodeContext& ctx, const Parts& parts,
               std::uint32_t index, std::uint32_t sink) {
    const NodeInstance& instance = *plan.instances[size_t(node)];
    const DividedTask& made = parts.header().tasks[index];
    const TileGrid grid(made.extent, parts.header().tile);
    if (grid.size() != made.items)
        throw Error(fmt::format("the parts hold {} tiles of '{}', {} x {} pixels have {}",
                                made.items, made.name, made.extent.width, made.extent.height,
                                grid.size()));
    const Inputs in = empty_inputs(plan.graph->nodes[size_t(node)], made.extent);
    const std::shared_ptr<void> result = instance.make_result();
    instance.open(in, made.extent, result.get());
    std::mutex mutex;
    std::vector<std::shared_ptr<void>> scratches, idle;  // all live until the sink is closed
    std::atomic<size_t> finished = 0;
    ctx.parallel(grid.size(), 16, [&](size_t begin, size_t end) {
        std::shared_ptr<void> scratch;
        {
            const std::lock_guard lock(mutex);
            if (idle.empty()) idle.push_back(scratches.emplace_back(instance.make_scratch()));
            scratch = std::move(idle.back());
            idle.pop_back();
        }
        Inputs tile_in = in;
        for (size_t t = begin; t < end; ++t) {
            tile_in.tile_ = grid.tile(t);
            instance.begin(tile_in, scratch.get());
            ByteReader from = parts.read(index, sink, t);
            try {
                instance.load(tile_in, from, scratch.get());
            } catch (const Error& error) {
                throw Error(fmt::format("{}: tile {} {}", parts.path_of(t), t, error.what()));
            }
            if (from.left() > 0)
                throw Error(fmt::format("{}: tile {} holds more than this graph makes",
                                        parts.path_of(t), t));
            instance.end(tile_in, scratch.get(), result.get());
            ctx.progress(double(++finished), double(grid.size()), "tiles");
        }
        const std::lock_guard lock(mutex);
        idle.push_back(std::move(scratch));
    });
    Outputs out = values.outputs_of(node);
    ctx.speak_for(plan.graph->nodes[size_t(node)].name);
    instance.close(in, result.get(), out, ctx);
}

}  // namespace

void run_pieces(const Plan& plan, const Task& task, Values& values, NodeContext& ctx,
                const RunOptions& options, DividedTask& made, std::uint32_t index) {
    const int node = task.nodes.front();
    const NodeInstance& instance = *plan.instances[size_t(node)];
    guarded(node, [&] {
        const Inputs in = values.inputs_of(node);
        made.items = instance.pieces(in);
        const auto first = size_t(options.shard.index - 1), step = size_t(options.shard.count);
        const size_t own = made.items > first ? (made.items - first + step - 1) / step : 0;
        std::atomic<size_t> finished = 0;
        ctx.progress(0, double(own), "pieces");
        ctx.parallel(own, 1, [&](size_t begin, size_t end) {
            ByteWriter bytes;
            for (size_t i = begin; i < end; ++i) {
                bytes.clear();
                instance.piece(in, first + i * step, bytes, ctx);
                options.part->add(index, 0, first + i * step, bytes.bytes());
                ctx.progress(double(++finished), double(own), "pieces");
            }
        });
    });
}

void join_task(const Plan& plan, const Task& task, Values& values, NodeContext& ctx,
               const RunOptions& options) {
    const Parts& parts = *options.parts;
    const int first = task.nodes.front();
    std::uint32_t index = 0;
    guarded(first, [&] { index = index_in(parts, plan.graph->nodes[size_t(first)].name); });
    if (!task.segment) {
        guarded(first, [&] {
            Outputs out = values.outputs_of(first);
            plan.instances[size_t(first)]->join(PartPieces(parts, index), out, ctx);
        });
        return;
    }
    const std::vector<std::string>& sinks = parts.header().tasks[index].sinks;
    for (const int node : task.nodes) {
        if (plan.instances[size_t(node)]->form() != Form::sink) continue;
        guarded(node, [&] {
            const auto found =
                std::find(sinks.begin(), sinks.end(), plan.graph->nodes[size_t(node)].name);
            if (found == sinks.end()) throw Error("the parts hold nothing of it");
            join_sink(plan, node, values, ctx, parts, index, std::uint32_t(found - sinks.begin()));
        });
    }
}

}  // namespace weft
