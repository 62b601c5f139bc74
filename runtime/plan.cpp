#include "runtime/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
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

// Which stream nodes run together. Nodes that streams connect are one component; where a node of a
// component needs a value that a sink of the same component makes, it belongs to a later pass, and
// the stages before it run once more there (they are pure: the same batches come out).
class Segments {
  public:
    Segments(const Graph& graph, const std::vector<bool>& needed) : graph_(graph) {
        const size_t count = graph.nodes.size();
        component_.resize(count);
        for (size_t n = 0; n < count; ++n) component_[n] = int(n);
        for (size_t n = 0; n < count; ++n)
            for_stream_inputs(int(n), [&](int from) { unite(int(n), from); });
        passes(needed);
    }

    struct Segment {
        int component, pass;
        std::vector<int> nodes;
    };
    std::vector<Segment> segments;

  private:
    template <class Visit>
    void for_stream_inputs(int node, Visit visit) const {
        for (const auto& links : graph_.nodes[size_t(node)].inputs)
            for (const Link& link : links)
                if (output_of(graph_, link).stream) visit(link.node);
    }
    int root(int n) {
        while (component_[size_t(n)] != n) n = component_[size_t(n)];
        return n;
    }
    void unite(int a, int b) {
        a = root(a);
        b = root(b);
        component_[size_t(std::max(a, b))] = std::min(a, b);
    }

    void passes(const std::vector<bool>& needed) {
        const size_t count = graph_.nodes.size();
        std::vector<std::map<int, int>> least(count);  // by component: the pass whose values are needed, plus one
        std::vector<int> pass(count, 0);
        for (size_t n = 0; n < count; ++n) {
            const bool stream = is_stream_node(graph_.nodes[n]);
            for (const auto& links : graph_.nodes[n].inputs)
                for (const Link& link : links) {
                    const size_t from = size_t(link.node);
                    for (const auto& [component, level] : least[from])
                        least[n][component] = std::max(least[n][component], level);
                    if (!is_stream_node(graph_.nodes[from])) continue;
                    const int level = pass[from] + (output_of(graph_, link).stream ? 0 : 1);
                    int& mine = least[n][root(link.node)];
                    mine = std::max(mine, level);
                }
            if (stream) pass[n] = least[n].count(root(int(n))) ? least[n][root(int(n))] : 0;
        }
        std::map<std::pair<int, int>, std::set<int>> members;
        for (size_t n = 0; n < count; ++n)
            if (needed[n] && is_stream_node(graph_.nodes[n]))
                add_with_ancestors(int(n), members[{root(int(n)), pass[n]}]);
        for (auto& [key, nodes] : members) {
            // A pass that only repeats stages which a later pass of the component runs anyway is not run.
            const bool makes = std::any_of(nodes.begin(), nodes.end(), [&](int n) {
                return pass[size_t(n)] == key.second && ends_here(n, needed);
            });
            if (makes) segments.push_back({key.first, key.second, {nodes.begin(), nodes.end()}});
        }
    }
    // A sink, or a stage whose stream nobody needed reads.
    bool ends_here(int node, const std::vector<bool>& needed) const {
        for (const PortDecl& port : graph_.nodes[size_t(node)].type->outputs)
            if (!port.stream) return true;
        for (size_t n = 0; n < graph_.nodes.size(); ++n) {
            bool reads = false;
            if (needed[n]) for_stream_inputs(int(n), [&](int from) { reads |= from == node; });
            if (reads) return false;
        }
        return true;
    }
    void add_with_ancestors(int node, std::set<int>& into) const {
        if (!into.insert(node).second) return;
        for_stream_inputs(node, [&](int from) { add_with_ancestors(from, into); });
    }

    const Graph& graph_;
    std::vector<int> component_;
};

std::string segment_name(const Graph& graph, const std::vector<int>& nodes) {
    const std::string& first = graph.nodes[size_t(nodes.front())].name;
    const std::string& last = graph.nodes[size_t(nodes.back())].name;
    return nodes.size() == 1 ? first : first + " ... " + last;
}

// Which task makes each value. A sink that is in several passes' segments makes its value in one.
std::vector<int> task_of_nodes(const Graph& graph, const std::vector<Task>& tasks) {
    std::vector<int> task(graph.nodes.size(), -1);
    for (size_t t = 0; t < tasks.size(); ++t)
        for (int n : tasks[t].nodes)
            if (task[size_t(n)] < 0) task[size_t(n)] = int(t);
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

void estimate(Plan& plan, int threads) {
    const Graph& graph = *plan.graph;
    plan.shapes.resize(graph.nodes.size());
    std::vector<double> scratch(graph.nodes.size(), 0);
    for (size_t n = 0; n < graph.nodes.size(); ++n) {
        const GraphNode& node = graph.nodes[n];
        plan.shapes[n].resize(node.type->outputs.size());
        if (!plan.instances[n]) continue;
        Shapes in;
        for (size_t i = 0; i < node.inputs.size(); ++i)
            for (const Link& link : node.inputs[i])
                in.ports.emplace_back(node.type->inputs[i].name, plan.shapes[size_t(link.node)][size_t(link.port)]);
        try {
            const Cost cost = plan.instances[n]->cost(in);
            for (const auto& [port, shape] : cost.outputs)
                if (const int index = node.type->find_output(port); index >= 0) plan.shapes[n][size_t(index)] = shape;
            scratch[n] = cost.scratch_bytes;
        } catch (const Error& error) {
            throw Error(fmt::format("{}: error: '{}' ({}): {}", where(node.place), node.name, node.type->type, error.what()));
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
    for (size_t t = 0; t < plan.tasks.size(); ++t)
        for (int n : plan.tasks[t].nodes)
            for (const auto& links : graph.nodes[size_t(n)].inputs)
                for (const Link& link : links)
                    if (!output_of(graph, link).stream) readers[{link.node, link.port}].insert(int(t));
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

}  // namespace

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
    for (const Segments::Segment& segment : Segments(graph, needed).segments) {
        Task task;
        task.segment = true;
        task.nodes = segment.nodes;
        task.name = segment_name(graph, segment.nodes);
        plan.tasks.push_back(std::move(task));
    }
    // Tasks in the order of their first node, so that a plan reads like its document.
    std::stable_sort(plan.tasks.begin(), plan.tasks.end(),
                     [](const Task& a, const Task& b) { return a.nodes.back() < b.nodes.back(); });
    link_tasks(plan);
    find_lifetimes(plan);
    estimate(plan, options.threads);

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
