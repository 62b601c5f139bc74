#include "runtime/segment.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>

namespace weft {
namespace {

using Clock = std::chrono::steady_clock;

double ns_since(Clock::time_point start) {
    return double(std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start).count());
}

// One stage on one worker.
struct Stage {
    const StagePlan* plan = nullptr;
    int node = -1;                                   // its first, for messages
    const NodeInstance* instance = nullptr;
    Form form = Form::stage;
    Inputs in;
    Outputs out;
    std::shared_ptr<void> scratch;
    std::vector<std::shared_ptr<void>> owned;        // batches it makes
    const Batch* follows = nullptr;                  // the batch whose records its outputs are about
    std::vector<Batch*> same_records;                // outputs with the records of `follows`
    std::vector<Batch*> selections;
    std::vector<std::pair<const TypeInfo*, const void*>> counted;
    std::vector<std::pair<StreamTap*, Slot>> taps;
    // What it took so far.
    Items items;
    double tile_ns = 0, cpu_ns = 0, wall_ns = 0;
};

struct Worker {
    std::vector<Stage> stages;
    std::map<std::pair<int, int>, void*> made;       // batches, by the output they stand at
    ByteWriter bytes;  // of a tile, for a part
};

class Segment {
  public:
    Segment(const Plan& plan, const Task& task, Values& values, NodeContext& ctx, Monitor& monitor, const RunOptions& options,
            std::uint32_t index)
        : plan_(plan),
          graph_(*plan.graph),
          task_(task),
          values_(values),
          ctx_(ctx),
          monitor_(monitor),
          options_(options),
          sharded_(task.divided && options.part),
          index_(index) {}

    SegmentReport run(DividedTask* made) {
        const auto start = Clock::now();
        const int source = task_.nodes.front();
        Inputs source_in = values_.inputs_of(source);
        guarded(source, [&] { extent_ = plan_.instances[size_t(source)]->extent(source_in); });
        for (const Tap& tap : plan_.taps)
            if (graph_.nodes[size_t(tap.from.node)].type->outputs[size_t(tap.from.port)].stream && index_of(tap.from.node) >= 0)
                taps_.push_back(std::make_unique<StreamTap>(tap, std::max(extent_.width, 1)));
        if (!sharded_) open_sinks();

        const TileGrid grid(extent_, options_.tile);
        const size_t first = sharded_ ? size_t(options_.shard.index - 1) : 0, step = sharded_ ? size_t(options_.shard.count) : 1;
        const size_t tiles = grid.size() > first ? (grid.size() - first + step - 1) / step : 0;
        std::atomic<size_t> finished = 0;
        ctx_.progress(0, double(tiles), "tiles");
        ctx_.parallel(tiles, 1, [&](size_t begin, size_t end) {
            std::unique_ptr<Worker> worker = take_worker();
            for (size_t t = begin; t < end; ++t) {
                run_tile(*worker, grid.tile(first + t * step));
                ctx_.progress(double(++finished), double(tiles), "tiles");
            }
            give_back(std::move(worker));
        });
        if (!sharded_) close_sinks();
        for (const auto& tap : taps_) tap->write();
        if (made) {
            made->extent = extent_;
            made->items = grid.size();
            for (const int node : task_.nodes)
                if (plan_.instances[size_t(node)]->form() == Form::sink) made->sinks.push_back(graph_.nodes[size_t(node)].name);
        }
        SegmentReport report = summary();
        report.tiles = tiles;
        report.wall_s = ns_since(start) * 1e-9;
        return report;
    }

  private:
    const NodeInstance& instance_of(const StagePlan& stage) const {
        return stage.fused ? *stage.fused : *plan_.instances[size_t(stage.nodes[0])];
    }

    int index_of(int node) const {
        const auto found = std::find(task_.nodes.begin(), task_.nodes.end(), node);
        return found == task_.nodes.end() ? -1 : int(found - task_.nodes.begin());
    }

    void open_sinks() {
        results_.resize(task_.stages.size());
        for (size_t i = 0; i < task_.stages.size(); ++i) {
            const int node = task_.stages[i].nodes[0];
            const NodeInstance& instance = instance_of(task_.stages[i]);
            if (instance.form() != Form::sink) continue;
            results_[i] = instance.make_result();
            Inputs in = values_.inputs_of(node);
            in.extent_ = extent_;
            guarded(node, [&] { instance.open(in, extent_, results_[i].get()); });
        }
    }

    void close_sinks() {
        for (size_t i = 0; i < task_.stages.size(); ++i) {
            const int node = task_.stages[i].nodes[0];
            const NodeInstance& instance = instance_of(task_.stages[i]);
            if (instance.form() != Form::sink) continue;
            Inputs in = values_.inputs_of(node);
            in.extent_ = extent_;
            Outputs out = values_.outputs_of(node);
            ctx_.speak_for(plan_.graph->nodes[size_t(node)].name);
            guarded(node, [&] { instance.close(in, results_[i].get(), out, ctx_); });
        }
    }

    std::unique_ptr<Worker> take_worker() {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                std::unique_ptr<Worker> worker = std::move(idle_.back());
                idle_.pop_back();
                return worker;
            }
        }
        return make_worker();
    }
    void give_back(std::unique_ptr<Worker> worker) {
        const std::lock_guard lock(mutex_);
        idle_.push_back(std::move(worker));
    }

    std::unique_ptr<Worker> make_worker() {
        auto worker = std::make_unique<Worker>();
        worker->stages.resize(task_.stages.size());
        for (size_t i = 0; i < task_.stages.size(); ++i) {
            Stage& stage = worker->stages[i];
            stage.plan = &task_.stages[i];
            stage.node = stage.plan->nodes[0];
            stage.instance = &instance_of(*stage.plan);
            stage.form = stage.instance->form();
            stage.scratch = stage.instance->make_scratch();
            stage.in = values_.inputs_of(*stage.plan);
            stage.in.extent_ = extent_;
            link_streams(*worker, stage);
            make_outputs(*worker, stage);
        }
        return worker;
    }

    void link_streams(Worker& worker, Stage& stage) {
        for (size_t p = 0; p < stage.plan->inputs.size(); ++p) {
            const StagePlan::Port& place = stage.plan->inputs[p];
            const GraphNode& node = graph_.nodes[size_t(place.node)];
            const PortDecl& port = node.type->inputs[size_t(place.port)];
            if (!port.stream) continue;
            for (const Link& link : node.inputs[size_t(place.port)]) {
                Slot& slot = stage.in.slots[p];
                slot.object = worker.made.at({link.node, link.port});
                slot.more.push_back(slot.object);
                const bool per_batch = graph_.nodes[size_t(link.node)].type->outputs[size_t(link.port)].per_batch;
                if (!stage.follows && !port.branch && !per_batch) stage.follows = slot.type->batch(slot.object);
                if (stage.form == Form::sink) stage.counted.emplace_back(slot.type, slot.object);
            }
        }
    }

    void make_outputs(Worker& worker, Stage& stage) {
        for (const StagePlan::Port& place : stage.plan->outputs) {
            const PortDecl& port = graph_.nodes[size_t(place.node)].type->outputs[size_t(place.port)];
            const Link link{place.node, place.port};
            Slot slot;
            slot.port = place.name;
            slot.type = &values_.type(link);
            if (port.stream && stream_wanted(link)) {
                stage.owned.push_back(slot.type->make());
                slot.object = stage.owned.back().get();
                worker.made[{link.node, link.port}] = slot.object;
                Batch* batch = slot.type->batch(slot.object);
                (port.selects || stage.form == Form::source ? stage.selections : stage.same_records).push_back(batch);
                stage.counted.emplace_back(slot.type, slot.object);
                for (const auto& tap : taps_)
                    if (tap->tap().from.node == link.node && tap->tap().from.port == link.port)
                        stage.taps.emplace_back(tap.get(), slot);
            }
            stage.out.slots.push_back(std::move(slot));
        }
    }

    bool stream_wanted(Link link) const {
        for (int n : task_.nodes)
            for (const auto& links : graph_.nodes[size_t(n)].inputs)
                for (const Link& l : links)
                    if (l.node == link.node && l.port == link.port) return true;
        return std::any_of(taps_.begin(), taps_.end(), [&](const auto& tap) {
            return tap->tap().from.node == link.node && tap->tap().from.port == link.port;
        });
    }

    void run_tile(Worker& worker, const Tile& tile) {
        const std::uint64_t begin_us = now_us(), cpu_begin = thread_cpu_ns();
        const auto start = Clock::now();
        for (Stage& stage : worker.stages) {
            stage.in.tile_ = tile;
            stage.tile_ns = 0;
            if (stage.form == Form::sink)
                guarded(stage.node, [&] { stage.instance->begin(stage.in, stage.scratch.get()); });
        }
        for (size_t index = 0; run_batch(worker, index); ++index) ctx_.check_cancelled();
        if (sharded_) {
            hand_out_tile(worker, tile);
        } else {
            for (size_t i = 0; i < worker.stages.size(); ++i)
                if (Stage& stage = worker.stages[i]; stage.form == Form::sink)
                    guarded(stage.node, [&] { stage.instance->end(stage.in, stage.scratch.get(), results_[i].get()); });
        }

        // A stage's clock counts while its thread is held up by others; its tile's CPU time does not.
        const double wall = std::max(ns_since(start), 1.0), cpu = double(thread_cpu_ns() - cpu_begin);
        for (Stage& stage : worker.stages) {
            stage.wall_ns += stage.tile_ns;
            stage.cpu_ns += stage.tile_ns * std::min(1.0, cpu / wall);
        }
        if (monitor_.tracing) trace_tile(worker, tile, begin_us);
    }

    void hand_out_tile(Worker& worker, const Tile& tile) {
        std::uint32_t sink = 0;
        for (Stage& stage : worker.stages) {
            if (stage.form != Form::sink) continue;
            worker.bytes.clear();
            guarded(stage.node, [&] {
                stage.instance->save(stage.in, stage.scratch.get(), worker.bytes);
                options_.part->add(index_, sink, tile.index, worker.bytes.bytes());
            });
            ++sink;
        }
    }

    bool run_batch(Worker& worker, size_t index) {
        auto before = Clock::now();
        for (Stage& stage : worker.stages) {
            if (stage.form == Form::source) {
                bool more = false;
                guarded(stage.node, [&] { more = stage.instance->next(stage.in, index, stage.out, stage.scratch.get()); });
                if (!more) return false;
                count(stage);
            } else {
                run_stage(stage);
            }
            for (auto& [tap, slot] : stage.taps) {
                const Batch& batch = *slot.type->batch(slot.object);
                if (batch.size() > 0) tap->take(*slot.type, slot.object, batch, index);
            }
            const auto after = Clock::now();
            stage.tile_ns += double((after - before).count());
            before = after;
        }
        return true;
    }

    void run_stage(Stage& stage) {
        const bool empty = !stage.follows || stage.follows->size() == 0;
        for (Batch* batch : stage.same_records) {
            batch->pixels = empty ? std::span<const std::uint32_t>() : stage.follows->pixels;
            batch->parents = empty ? std::span<const std::uint32_t>() : stage.follows->parents;
        }
        if (empty) {
            for (Batch* batch : stage.selections) *batch = Batch();
            return;
        }
        guarded(stage.node, [&] {
            if (stage.form == Form::sink) stage.instance->take(stage.in, stage.scratch.get());
            else stage.instance->batch(stage.in, stage.out, stage.scratch.get());
        });
        count(stage);
    }

    // A batch held by several ports is counted by its items once: the first that counts a name wins.
    static void count(Stage& stage) {
        Items batch;
        for (const auto& [type, object] : stage.counted) {
            if (!type->count) continue;
            Items one;
            type->count(object, one);
            for (const Items::Item& item : one.all()) {
                const auto known = std::find_if(batch.all().begin(), batch.all().end(),
                                                [&](const Items::Item& b) { return b.name == item.name; });
                if (known == batch.all().end()) batch.add(item.name, item.count);
            }
        }
        for (const Items::Item& item : batch.all()) stage.items.add(item.name, item.count);
    }

    void trace_tile(const Worker& worker, const Tile& tile, std::uint64_t begin_us) {
        monitor_.span({fmt::format("tile {}", tile.index), "tile", begin_us, now_us() - begin_us, thread_number(),
                       fmt::format("{{\"x\":{},\"y\":{},\"segment\":{}}}", tile.x0, tile.y0, Json(task_.name).dump())});
        // Inside it, each stage's total over the tile's batches, one after the other.
        std::uint64_t at = begin_us;
        for (const Stage& stage : worker.stages) {
            const std::uint64_t us = std::uint64_t(stage.tile_ns / 1000);
            monitor_.span({stage.plan->name(graph_), "stage, all batches of the tile", at, us, thread_number(), ""});
            at += us;
        }
    }

    SegmentReport summary() {
        SegmentReport report;
        report.name = task_.name;
        for (size_t i = 0; i < task_.stages.size(); ++i) {
            StageReport stage;
            stage.name = task_.stages[i].name(graph_);
            stage.type = task_.stages[i].type(graph_);
            for (const auto& worker : idle_) {
                stage.cpu_s += worker->stages[i].cpu_ns * 1e-9;
                stage.wall_s += worker->stages[i].wall_ns * 1e-9;
                for (const Items::Item& item : worker->stages[i].items.all()) stage.items[std::string(item.name)] += item.count;
            }
            report.stages.push_back(std::move(stage));
        }
        return report;
    }

    const Plan& plan_;
    const Graph& graph_;
    const Task& task_;
    Values& values_;
    NodeContext& ctx_;
    Monitor& monitor_;
    const RunOptions& options_;
    const bool sharded_;
    const std::uint32_t index_;
    Extent extent_;
    std::vector<std::shared_ptr<void>> results_;
    std::vector<std::unique_ptr<StreamTap>> taps_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Worker>> idle_;
};

}  // namespace

TileGrid::TileGrid(const Extent& of, int tile)
    : extent(of),
      side(std::max(tile, 1)),
      across(size_t(std::max((of.width + side - 1) / side, 0))),
      down(size_t(std::max((of.height + side - 1) / side, 0))) {}

Tile TileGrid::tile(size_t index) const {
    const int x = int(index % across) * side, y = int(index / across) * side;
    return {index, x, y, std::min(x + side, extent.width), std::min(y + side, extent.height)};
}

SegmentReport run_segment(const Plan& plan, const Task& task, Values& values, NodeContext& ctx, Monitor& monitor,
                          const RunOptions& options, DividedTask* made, std::uint32_t index) {
    return Segment(plan, task, values, ctx, monitor, options, index).run(made);
}

}  // namespace weft
