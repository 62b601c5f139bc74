#include "runtime/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "runtime/registry.h"
#include "runtime/tap.h"

namespace weft {
namespace {

const PortDecl& output_of(const Graph& graph, Link link) {
    return graph.nodes[size_t(link.node)].type->outputs[size_t(link.port)];
}

bool is_stream_node(const GraphNode& node) {
    const auto stream = [](const PortDecl& port) { return port.stream; };
    return std::any_of(node.type->inputs.begin(), node.type->inputs.end(), stream) ||
           std::any_of(node.type->outputs.begin(), node.type->outputs.end(), stream);
}

// Nodes that a writing node or a tap needs.
std::vector<bool> needed_nodes(const Graph& graph, const std::vector<Tap>& taps) {
    std::vector<bool> needed(graph.nodes.size(), false);
    for (size_t n = 0; n < graph.nodes.size(); ++n) needed[n] = graph.nodes[n].type->writes;
    for (const auto& [name, link] : graph.outputs) needed[size_t(link.node)] = true;
    for (const Tap& tap : taps) needed[size_t(tap.from.node)] = true;
    for (size_t n = graph.nodes.size(); n-- > 0;)
        if (needed[n])
            for (const auto& links : graph.nodes[n].inputs)
                for (const Link& link : links) needed[size_t(link.node)] = true;
    return needed;
}

// Which stream nodes run together: those that streams connect. The checker has seen to it that they
// have one source and that none of them waits for a value that their own sinks make.
std::vector<std::vector<int>> connected_by_streams(const Graph& graph, const std::vector<bool>& needed) {
    std::vector<int> parent(graph.nodes.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int n) {
        while (parent[size_t(n)] != n) n = parent[size_t(n)];
        return n;
    };
    std::map<int, std::vector<int>> runs;
    for (size_t n = 0; n < graph.nodes.size(); ++n)
        for (const auto& links : graph.nodes[n].inputs)
            for (const Link& link : links)
                if (output_of(graph, link).stream) {
                    const int a = root(int(n)), b = root(link.node);
                    parent[size_t(std::max(a, b))] = std::min(a, b);
                }
    for (size_t n = 0; n < graph.nodes.size(); ++n)
        if (needed[n] && is_stream_node(graph.nodes[n])) runs[root(int(n))].push_back(int(n));
    std::vector<std::vector<int>> segments;
    for (auto& [first, nodes] : runs) segments.push_back(std::move(nodes));
    return segments;
}

std::string segment_name(const Graph& graph, const std::vector<int>& nodes) {
    const std::string& first = graph.nodes[size_t(nodes.front())].name;
    const std::string& last = graph.nodes[size_t(nodes.back())].name;
    return nodes.size() == 1 ? first : first + " ... " + last;
}

// Which task makes each value.
std::vector<int> task_of_nodes(const Graph& graph, const std::vector<Task>& tasks) {
    std::vector<int> task(graph.nodes.size(), -1);
    for (size_t t = 0; t < tasks.size(); ++t)
        for (int n : tasks[t].nodes) task[size_t(n)] = int(t);
    return task;
}

void sort_tasks(std::vector<Task>& tasks) {
    // Kahn's order, lowest index first: stable, so plans read like their documents.
    std::vector<size_t> order;
    std::vector<bool> done(tasks.size(), false);
    while (order.size() < tasks.size()) {
        size_t next = tasks.size();
        for (size_t t = 0; t < tasks.size() && next == tasks.size(); ++t)
            if (!done[t] && std::all_of(tasks[t].needs.begin(), tasks[t].needs.end(), [&](size_t n) { return done[n]; }))
                next = t;
        if (next == tasks.size()) throw Error("the tasks of this graph wait for each other");  // the checker refuses cycles
        done[next] = true;
        order.push_back(next);
    }
    std::vector<size_t> place(tasks.size());
    for (size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
    std::vector<Task> sorted;
    for (size_t t : order) sorted.push_back(std::move(tasks[t]));
    for (Task& task : sorted) {
        for (size_t& need : task.needs) need = place[need];
        std::sort(task.needs.begin(), task.needs.end());
    }
    tasks = std::move(sorted);
}

// A stream has the size of the picture that what comes in is about, unless its node says another.
void pass_on_size(const NodeDecl& type, const Shapes& in, std::vector<Shape>& out) {
    for (size_t p = 0; p < out.size(); ++p) {
        if (!type.outputs[p].stream || out[p].width > 0) continue;
        for (const auto& [name, shape] : in.ports)
            if (shape.width > 0) {
                out[p].width = shape.width;
                out[p].height = shape.height;
                break;
            }
    }
}

void estimate(Plan& plan, int threads, const std::map<std::string, Shape>& shapes) {
    const Graph& graph = *plan.graph;
    plan.shapes.resize(graph.nodes.size());
    std::vector<double> scratch(graph.nodes.size(), 0);
    for (size_t n = 0; n < graph.nodes.size(); ++n) {
        const GraphNode& node = graph.nodes[n];
        plan.shapes[n].resize(node.type->outputs.size());
        for (size_t p = 0; p < plan.shapes[n].size(); ++p)
            if (const auto known = shapes.find(plan.name_of({int(n), int(p)})); known != shapes.end()) plan.shapes[n][p] = known->second;
        if (!plan.instances[n]) continue;
        Shapes in;  // of unconnected inputs: nothing
        for (size_t i = 0; i < node.inputs.size(); ++i)
            for (const Link& link : node.inputs[i])
                in.ports.emplace_back(node.type->inputs[i].name, plan.shapes[size_t(link.node)][size_t(link.port)]);
        try {
            const Cost cost = plan.instances[n]->cost(in);
            for (const auto& [port, shape] : cost.outputs)
                if (const int index = node.type->find_output(port); index >= 0) plan.shapes[n][size_t(index)] = shape;
            scratch[n] = cost.scratch_bytes;
            pass_on_size(*node.type, in, plan.shapes[n]);
        } catch (const Error& error) {
            throw PlacedError(node.place, fmt::format("'{}' ({}): {}", node.name, node.type->type, error.what()));
        }
    }
    double live = 0;
    for (size_t t = 0; t < plan.tasks.size(); ++t) {
        Task& task = plan.tasks[t];
        for (const Link& link : task.makes) task.made_bytes += plan.shapes[size_t(link.node)][size_t(link.port)].bytes;
        for (int n : task.nodes) task.scratch_bytes += scratch[size_t(n)] * (task.segment ? threads : 1);
        live += task.made_bytes;
        task.live_bytes = live;
        if (live + task.scratch_bytes > plan.peak_bytes) {
            plan.peak_bytes = live + task.scratch_bytes;
            plan.peak_task = t;
        }
        for (const Link& link : task.last_uses) live -= plan.shapes[size_t(link.node)][size_t(link.port)].bytes;
    }
}

void link_tasks(Plan& plan) {
    const Graph& graph = *plan.graph;
    const std::vector<int> task_of = task_of_nodes(graph, plan.tasks);
    for (Task& task : plan.tasks) {
        if (task.divided && plan.work == Work::merge) continue;  // comes from files
        std::set<size_t> needs;
        for (int n : task.nodes)
            for (const auto& links : graph.nodes[size_t(n)].inputs)
                for (const Link& link : links)
                    if (!output_of(graph, link).stream) needs.insert(size_t(task_of[size_t(link.node)]));
        task.needs.assign(needs.begin(), needs.end());
    }
    sort_tasks(plan.tasks);
}

void find_lifetimes(Plan& plan) {
    const Graph& graph = *plan.graph;
    std::map<std::pair<int, int>, std::set<int>> readers;
    for (size_t t = 0; t < plan.tasks.size(); ++t) {
        if (plan.tasks[t].divided && plan.work == Work::merge) continue;
        for (int n : plan.tasks[t].nodes)
            for (const auto& links : graph.nodes[size_t(n)].inputs)
                for (const Link& link : links)
                    if (!output_of(graph, link).stream) readers[{link.node, link.port}].insert(int(t));
    }
    const std::vector<int> task_of = task_of_nodes(graph, plan.tasks);
    for (const auto& [key, tasks] : readers) {
        const Link link{key.first, key.second};
        plan.tasks[size_t(task_of[size_t(link.node)])].makes.push_back(link);
        plan.tasks[size_t(*tasks.rbegin())].last_uses.push_back(link);
    }
    plan.readers.resize(graph.nodes.size());
    for (size_t n = 0; n < graph.nodes.size(); ++n) {
        plan.readers[n].assign(graph.nodes[n].type->outputs.size(), 0);
        for (size_t p = 0; p < plan.readers[n].size(); ++p)
            if (const auto found = readers.find({int(n), int(p)}); found != readers.end())
                plan.readers[n][p] = int(found->second.size());
    }
}

// Leaves what a shard needs (the divided tasks and all before them), or the merge (all that is written, back to
// the divided tasks).
void keep_only(Plan& plan, const std::vector<size_t>& divided) {
    std::vector<bool> keep(plan.tasks.size(), false);
    for (const size_t t : divided) {
        plan.tasks[t].divided = true;
        keep[t] = plan.work == Work::shard;
    }
    if (plan.work == Work::merge)
        for (size_t t = 0; t < plan.tasks.size(); ++t)
            for (int n : plan.tasks[t].nodes) {
                keep[t] = keep[t] || plan.graph->nodes[size_t(n)].type->writes;
                for (const auto& [name, link] : plan.graph->outputs) keep[t] = keep[t] || link.node == n;
            }
    for (size_t t = plan.tasks.size(); t-- > 0;)  // every task stands after those it needs
        if (keep[t] && !(plan.work == Work::merge && plan.tasks[t].divided))
            for (const size_t need : plan.tasks[t].needs) keep[need] = true;
    std::vector<Task> kept;
    for (size_t t = 0; t < plan.tasks.size(); ++t) {
        if (keep[t]) kept.push_back(std::move(plan.tasks[t]));
        else if (plan.work == Work::merge)  // not looked at: what it reads may not be here
            for (int n : plan.tasks[t].nodes) plan.instances[size_t(n)].reset();
    }
    plan.tasks = std::move(kept);
    for (Task& task : plan.tasks) task.needs.clear();
    link_tasks(plan);
}

}  // namespace

std::string Plan::name_of(Link link) const {
    const GraphNode& node = graph->nodes[size_t(link.node)];
    return node.name + "." + node.type->outputs[size_t(link.port)].name;
}

int Plan::readers_of(Link link) const { return readers[size_t(link.node)][size_t(link.port)]; }

Plan make_plan(const Graph& graph, const PlanOptions& options) {
    Plan plan;
    plan.graph = &graph;
    for (const std::string& text : options.taps) plan.taps.push_back(parse_tap(text, graph));

    const std::vector<bool> needed = needed_nodes(graph, plan.taps);
    plan.instances.resize(graph.nodes.size());
    for (size_t n = 0; n < graph.nodes.size(); ++n)
        if (needed[n]) plan.instances[n] = Registry::instance().type(graph.nodes[n].type->type)->make(graph.nodes[n].params);

    for (size_t n = 0; n < graph.nodes.size(); ++n)
        if (needed[n] && !is_stream_node(graph.nodes[n])) {
            Task task;
            task.nodes = {int(n)};
            task.name = graph.nodes[n].name;
            plan.tasks.push_back(std::move(task));
        }
    for (std::vector<int>& nodes : connected_by_streams(graph, needed)) {
        Task task;
        task.segment = true;
        task.name = segment_name(graph, nodes);
        task.nodes = std::move(nodes);
        task.stages = stages_of(graph, task.nodes, options.fuse, [&](Link link) {
            return std::any_of(plan.taps.begin(), plan.taps.end(), [&](const Tap& tap) {
                return tap.from.node == link.node && tap.from.port == link.port;
            });
        });
        plan.tasks.push_back(std::move(task));
    }
    // Tasks in the order of their first node, so that a plan reads like its document.
    std::stable_sort(plan.tasks.begin(), plan.tasks.end(),
                     [](const Task& a, const Task& b) { return a.nodes.back() < b.nodes.back(); });
    link_tasks(plan);
    if (options.work != Work::whole) {
        if (!plan.taps.empty()) throw UsageError("--tap looks into a whole run; it cannot be had of a shard or a merge");
        const std::vector<size_t> divided = divided_tasks(plan, options.divide);
        plan.work = options.work;
        keep_only(plan, divided);
    }
    find_lifetimes(plan);
    estimate(plan, options.threads, options.shapes);

    if (options.memory_limit > 0 && plan.peak_bytes > options.memory_limit) {
        const Task& task = plan.tasks[plan.peak_task];
        throw Error(fmt::format(
            "this plan needs {} while '{}' runs ({} of values, {} of scratch), --memory allows {}; "
            "raise it, or make its inputs smaller ('weft plan' shows every node's share)",
            bytes_text(plan.peak_bytes), task.name, bytes_text(task.live_bytes), bytes_text(task.scratch_bytes),
            bytes_text(options.memory_limit)));
    }
    return plan;
}

}  // namespace weft
