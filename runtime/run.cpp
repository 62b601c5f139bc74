#include "runtime/run.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <set>

#include "runtime/provenance.h"
#include "runtime/segment.h"
#include "runtime/tap.h"
#include "runtime/values.h"

namespace weft {
namespace {

double process_cpu_s() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) { return double(t.tv_sec) + double(t.tv_usec) * 1e-6; };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_resident_bytes() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) * 1024;
}

// "samples from 'read' (read-samples)": what a failed node was given.
std::string inputs_text(const Graph& graph, int node) {
    const GraphNode& n = graph.nodes[size_t(node)];
    std::string text;
    for (size_t p = 0; p < n.inputs.size(); ++p)
        for (const Link& link : n.inputs[p]) {
            const GraphNode& from = graph.nodes[size_t(link.node)];
            text += fmt::format("{}{} from '{}' ({})", text.empty() ? "" : ", ", n.type->inputs[p].name, from.name, from.type->type);
        }
    return text;
}

class Run {
  public:
    Run(const Plan& plan, Executor& executor, Monitor& monitor, const RunOptions& options)
        : plan_(plan), executor_(executor), monitor_(monitor), options_(options), values_(plan) {
        left_.resize(plan.tasks.size());
        ended_.resize(plan.tasks.size());
        dependents_.resize(plan.tasks.size());
        reports_.resize(plan.tasks.size());
        divided_index_.resize(plan.tasks.size());
        for (size_t t = 0; t < plan.tasks.size(); ++t) {
            left_[t] = plan.tasks[t].needs.size();
            for (size_t need : plan.tasks[t].needs) dependents_[need].push_back(t);
            if (!plan.tasks[t].divided) continue;
            divided_index_[t] = std::uint32_t(divided_.size());
            divided_.push_back({plan.graph->nodes[size_t(plan.tasks[t].nodes.front())].name, plan.tasks[t].name, {}, 0, {}});
        }
    }

    RunResult run() {
        const std::uint64_t start = now_us();
        const double cpu_start = process_cpu_s();
        monitor_.begin(plan_);
        executor_.tasks([&](const Executor::Spawn& spawn) {
            for (size_t t = 0; t < plan_.tasks.size(); ++t)
                if (plan_.tasks[t].needs.empty()) ready_.insert(t);
            start_ready(spawn);
        });
        RunResult result;
        result.errors = std::move(errors_);
        result.cancelled = cancelled_;
        result.divided = std::move(divided_);
        for (size_t t = 0; t < plan_.tasks.size(); ++t) {
            if (monitor_.tasks[t].state != TaskProgress::done) continue;
            if (plan_.tasks[t].segment) result.segments.push_back(std::move(reports_[t].segment));
            else result.nodes.push_back(std::move(reports_[t].node));
        }
        result.wall_s = double(now_us() - start) * 1e-6;
        result.cpu_s = process_cpu_s() - cpu_start;
        result.peak_bytes = peak_resident_bytes();
        return result;
    }

  private:
    struct Report {
        StageReport node;
        SegmentReport segment;
    };

    // Who is free takes the ready task that comes first in the plan, and none that comes long after
    // the first that has not ended: what it makes would wait in memory for readers that come later
    // still, while who is free can help in the loops of those that run.
    static constexpr size_t ahead = 2;
    void start_ready(const Executor::Spawn& spawn) {
        size_t more = 0;
        {
            const std::lock_guard lock(mutex_);
            const auto near = size_t(std::distance(ready_.begin(), ready_.lower_bound(first_ + ahead)));
            more = near - std::min(near, spawned_);
            spawned_ += more;
        }
        for (; more > 0; --more)
            spawn([this, &spawn] {
                run_task(take_ready());
                start_ready(spawn);
            });
    }
    size_t take_ready() {
        const std::lock_guard lock(mutex_);
        --spawned_;
        return ready_.extract(ready_.begin()).value();
    }

    void run_task(size_t t) {
        TaskProgress& progress = monitor_.tasks[t];
        const Task& task = plan_.tasks[t];
        if (options_.stop && *options_.stop) {
            const std::lock_guard lock(mutex_);
            cancelled_ = true;
            return;
        }
        progress.started_us = now_us();
        progress.state = TaskProgress::running;
        const int first = task.nodes.front();
        try {
            NodeContext ctx(plan_.graph->nodes[size_t(first)].name, executor_, monitor_, progress, options_);
            if (task.divided) run_divided(t, ctx);
            else if (task.segment) reports_[t].segment = run_segment(plan_, task, values_, ctx, monitor_, options_);
            else run_node(t, first, ctx);
            write_taps(task, ctx);
        } catch (const Cancelled&) {
            const std::lock_guard lock(mutex_);
            cancelled_ = true;
            progress.state = TaskProgress::skipped;
            return;
        } catch (const StageError& error) {
            return fail(t, error.node, error.what());
        } catch (const std::bad_alloc&) {
            return fail(t, first, "ran out of memory");
        } catch (const std::exception& error) {
            return fail(t, first, error.what());
        }
        progress.ended_us = now_us();
        progress.state = TaskProgress::done;
        monitor_.span({task.name, task.segment ? "segment" : "node", progress.started_us,
                       progress.ended_us - progress.started_us, thread_number(), ""});
        release_inputs(task);
        const std::lock_guard lock(mutex_);
        for (const size_t next : dependents_[t])
            if (--left_[next] == 0) ready_.insert(next);
        end(t);
    }

    void run_divided(size_t t, NodeContext& ctx) {
        const Task& task = plan_.tasks[t];
        const GraphNode& n = plan_.graph->nodes[size_t(task.nodes.front())];
        const std::uint64_t start = now_us();
        StageReport& report = reports_[t].node;
        report.name = n.name;
        report.type = n.type->type;
        if (plan_.work == Work::merge) {
            reports_[t].segment.name = task.name;
            report.cpu_s = ctx.timed([&] { join_task(plan_, task, values_, ctx, options_); });
        } else if (task.segment) {
            reports_[t].segment = run_segment(plan_, task, values_, ctx, monitor_, options_, &divided_[divided_index_[t]], divided_index_[t]);
        } else {
            report.cpu_s = ctx.timed(
                [&] { run_pieces(plan_, task, values_, ctx, options_, divided_[divided_index_[t]], divided_index_[t]); });
        }
        report.wall_s = double(now_us() - start) * 1e-6;
    }

    void run_node(size_t t, int node, NodeContext& ctx) {
        const GraphNode& n = plan_.graph->nodes[size_t(node)];
        const std::uint64_t start = now_us();
        const Inputs in = values_.inputs_of(node);
        Outputs out = values_.outputs_of(node);
        StageReport& report = reports_[t].node;
        report.name = n.name;
        report.type = n.type->type;
        report.cpu_s = ctx.timed([&] { plan_.instances[size_t(node)]->run(in, out, ctx); });
        report.wall_s = double(now_us() - start) * 1e-6;
        for (const Slot& slot : out.slots) {
            if (!slot.object || !slot.type->count) continue;
            Items items;
            slot.type->count(slot.object, items);
            for (const Items::Item& item : items.all()) report.items[std::string(item.name)] += item.count;
        }
    }

    void write_taps(const Task& task, Context& ctx) {
        for (const Tap& tap : plan_.taps) {
            const bool here = std::find(task.nodes.begin(), task.nodes.end(), tap.from.node) != task.nodes.end();
            const GraphNode& node = plan_.graph->nodes[size_t(tap.from.node)];
            if (here && !node.type->outputs[size_t(tap.from.port)].stream)
                write_tap(tap, values_.type(tap.from), values_.get(tap.from), ctx);
        }
    }

    void release_inputs(const Task& task) {
        if (task.divided && plan_.work == Work::merge) return;  // it has none
        std::set<std::pair<int, int>> read;
        for (int n : task.nodes) {
            const GraphNode& node = plan_.graph->nodes[size_t(n)];
            for (size_t p = 0; p < node.inputs.size(); ++p)
                for (const Link& link : node.inputs[p])
                    if (!node.type->inputs[p].stream) read.insert({link.node, link.port});
        }
        for (const auto& [node, port] : read) values_.release({node, port});
    }

    // Under the mutex.
    void end(size_t t) {
        ended_[t] = true;
        while (first_ < ended_.size() && ended_[first_]) ++first_;
    }

    // Whatever waits for the task, directly or not, cannot run.
    void fail(size_t t, int node, const std::string& message) {
        const Graph& graph = *plan_.graph;
        NodeError error;
        error.node = graph.nodes[size_t(node)].name;
        error.place = graph.nodes[size_t(node)].place;
        error.message = message;
        if (const std::string inputs = inputs_text(graph, node); !inputs.empty()) error.message += " [" + inputs + "]";
        const std::lock_guard lock(mutex_);
        monitor_.tasks[t].state = TaskProgress::failed;
        end(t);
        std::vector<size_t> open = {t};
        while (!open.empty()) {
            const size_t from = open.back();
            open.pop_back();
            for (size_t next : dependents_[from]) {
                if (monitor_.tasks[next].state == TaskProgress::skipped) continue;
                monitor_.tasks[next].state = TaskProgress::skipped;
                end(next);
                for (int n : plan_.tasks[next].nodes) error.skipped.push_back(graph.nodes[size_t(n)].name);
                open.push_back(next);
            }
        }
        errors_.push_back(std::move(error));
    }

    const Plan& plan_;
    Executor& executor_;
    Monitor& monitor_;
    const RunOptions& options_;
    Values values_;
    std::mutex mutex_;
    std::vector<size_t> left_;
    std::vector<std::vector<size_t>> dependents_;
    std::set<size_t> ready_;
    size_t spawned_ = 0;       // of these are soon taken
    std::vector<bool> ended_;  // done, failed or skipped
    size_t first_ = 0;         // that has not ended
    std::vector<Report> reports_;
    std::vector<DividedTask> divided_;
    std::vector<std::uint32_t> divided_index_;  // of each task, in divided_
    std::vector<NodeError> errors_;
    bool cancelled_ = false;
};

Json stage_json(const StageReport& stage) {
    Json one = Json::object();
    one.set("name", stage.name);
    one.set("type", stage.type);
    one.set("wall_s", stage.wall_s);
    one.set("cpu_s", stage.cpu_s);
    Json& items = one.set("items", Json::object());
    for (const auto& [name, count] : stage.items) items.set(name, count);
    return one;
}

}  // namespace

RunResult run_plan(const Plan& plan, Executor& executor, Monitor& monitor, const RunOptions& options) {
    return Run(plan, executor, monitor, options).run();
}

std::string report_json(const RunResult& result, const Plan& plan, int threads) {
    Json report = Json::object();
    report.set("weft", program_version);
    report.set("graph", plan.graph->name);
    report.set("threads", threads);
    report.set("wall_s", result.wall_s);
    report.set("cpu_s", result.cpu_s);
    report.set("peak_bytes", result.peak_bytes);
    Json& nodes = report.set("nodes", Json::list());
    for (const StageReport& node : result.nodes) nodes.items.push_back(stage_json(node));
    Json& segments = report.set("segments", Json::list());
    for (const SegmentReport& segment : result.segments) {
        Json one = Json::object();
        one.set("name", segment.name);
        one.set("wall_s", segment.wall_s);
        one.set("tiles", std::uint64_t(segment.tiles));
        Json& stages = one.set("stages", Json::list());
        for (const StageReport& stage : segment.stages) stages.items.push_back(stage_json(stage));
        segments.items.push_back(std::move(one));
    }
    return report.dump(true) + "\n";
}

}  // namespace weft
