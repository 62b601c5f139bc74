// Which tasks of a plan shards share among them.
#include <fmt/format.h>

#include <algorithm>

#include "runtime/plan.h"

namespace weft {
namespace {

bool can_be_divided(const Plan& plan, const Task& task) {
    return task.segment || plan.instances[size_t(task.nodes.front())]->divides();
}

// Tasks that wait for task t, directly or not.
std::vector<bool> after(const Plan& plan, size_t t) {
    std::vector<bool> later(plan.tasks.size(), false);
    for (size_t i = t + 1; i < plan.tasks.size(); ++i)
        for (const size_t need : plan.tasks[i].needs)
            if (need == t || later[need]) later[i] = true;
    return later;
}

size_t task_of(const Plan& plan, const std::string& node) {
    const int index = plan.graph->find(node);
    for (size_t t = 0; t < plan.tasks.size() && index >= 0; ++t)
        if (std::count(plan.tasks[t].nodes.begin(), plan.tasks[t].nodes.end(), index) > 0) return t;
    std::vector<std::string> names;
    for (const Task& task : plan.tasks)
        for (int n : task.nodes) names.push_back(plan.graph->nodes[size_t(n)].name);
    throw UsageError(fmt::format("--divide {}: no node of this plan has that name{}", node,
                                 suggestion(node, names)));
}

std::string quoted(const Plan& plan, const std::vector<size_t>& tasks) {
    std::vector<std::string> names;
    for (const size_t t : tasks) names.push_back(fmt::format("'{}'", plan.tasks[t].name));
    return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<size_t> chosen_tasks(const Plan& plan, const std::vector<std::string>& nodes,
                                 const std::vector<size_t>& candidates) {
    std::vector<size_t> chosen;
    for (const std::string& node : nodes) {
        const size_t t = task_of(plan, node);
        if (std::count(candidates.begin(), candidates.end(), t) == 0)
            throw UsageError(fmt::format(
                "--divide {}: '{}' cannot be divided among shards; of this graph {}", node,
                plan.tasks[t].name,
                candidates.empty() ? "nothing can" : quoted(plan, candidates) + " can"));
        if (std::count(chosen.begin(), chosen.end(), t) == 0) chosen.push_back(t);
    }
    for (const size_t t : chosen) {
        const std::vector<bool> later = after(plan, t);
        for (const size_t other : chosen)
            if (later[other])
                throw UsageError(
                    fmt::format("--divide: '{}' waits for '{}', so a shard cannot do a part of "
                                "both; name one of them",
                                plan.tasks[other].name, plan.tasks[t].name));
    }
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

}  // namespace

std::vector<size_t> divided_tasks(const Plan& plan, const std::vector<std::string>& nodes) {
    std::vector<size_t> candidates, divided;
    for (size_t t = 0; t < plan.tasks.size(); ++t)
        if (can_be_divided(plan, plan.tasks[t])) candidates.push_back(t);
    if (!nodes.empty()) {
        divided = chosen_tasks(plan, nodes, candidates);
    } else {
        for (const size_t t : candidates) {
            const std::vector<bool> later = after(plan, t);
            if (std::none_of(candidates.begin(), candidates.end(),
                             [&](size_t other) { return later[other]; }))
                divided.push_back(t);
        }
        if (divided.empty())
            throw UsageError(
                "nothing in this graph can be divided among shards: it has no stream segment, and "
                "no node that makes its "
                "result in pieces; run it whole, without --shard");
    }
    for (const size_t t : divided)
        for (int n : plan.tasks[t].nodes) {
            const NodeInstance& instance = *plan.instances[size_t(n)];
            if (!plan.tasks[t].segment || instance.form() != Form::sink || instance.divides())
                continue;
            const GraphNode& node = plan.graph->nodes[size_t(n)];
            throw UsageError(fmt::format(
                "'{}' ({}) cannot hand out its tiles, so '{}' cannot be divided among shards; "
                "swap that node, choose what is divided with --divide NODE, or run without --shard",
                node.name, node.type->type, plan.tasks[t].name));
        }
    return divided;
}

}  // namespace weft
