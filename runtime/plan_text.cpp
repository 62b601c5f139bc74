#include <fmt/format.h>

#include <cstdlib>

#include "runtime/keys.h"
#include "runtime/plan.h"

namespace weft {
namespace {

std::string joined(const Plan& plan, const std::vector<Link>& links) {
    std::string text;
    for (const Link& link : links) text += (text.empty() ? "" : ", ") + plan.name_of(link);
    return text;
}

// The tasks that shards would divide; none where that is not possible.
std::vector<size_t> divisible(const Plan& plan) {
    try {
        return divided_tasks(plan, {});
    } catch (const UsageError&) {
        return {};
    }
}

std::string shape_text(const Shape& shape) {
    std::string text;
    if (shape.width > 0) text += fmt::format("{} x {}", shape.width, shape.height);
    if (shape.channels > 0) text += fmt::format(" x {}", shape.channels);
    if (shape.records > 0) text += fmt::format("{}{} records", text.empty() ? "" : ", ", shape.records);
    if (shape.bytes > 0) text += fmt::format("{}{}", text.empty() ? "" : ", ", bytes_text(shape.bytes));
    return text.empty() ? "size not known before the run" : text;
}

std::string_view form_text(const Plan& plan, const Task& task, const StagePlan& stage) {
    if (stage.fusion) return "fused";
    if (stage.nodes[0] == task.nodes.front()) return "source";
    return plan.instances[size_t(stage.nodes[0])]->form() == Form::sink ? "sink" : "stage";
}

}  // namespace

std::string bytes_text(double bytes) {
    if (bytes >= 1e9) return fmt::format("{:.3g} GB", bytes / 1e9);
    if (bytes >= 1e6) return fmt::format("{:.3g} MB", bytes / 1e6);
    if (bytes >= 1e3) return fmt::format("{:.3g} kB", bytes / 1e3);
    return fmt::format("{:.0f} B", bytes);
}

double parse_bytes(const std::string& text) {
    char* rest = nullptr;
    const double number = std::strtod(text.c_str(), &rest);
    const std::string unit = rest;
    const double factor = unit.empty() || unit == "B"     ? 1
                          : unit == "k" || unit == "K" || unit == "kB" || unit == "KB" ? 1e3
                          : unit == "M" || unit == "MB" ? 1e6
                          : unit == "G" || unit == "GB" ? 1e9
                          : unit == "T" || unit == "TB" ? 1e12
                                                        : 0;
    if (rest == text.c_str() || factor == 0 || !(number > 0))
        throw UsageError(fmt::format("'{}' is no amount of memory; expected a number with k, M, G or T, as in 8G", text));
    return number * factor;
}

std::string to_text(const Plan& plan, const Keys* keys) {
    const Graph& graph = *plan.graph;
    std::string text;
    for (size_t t = 0; t < plan.tasks.size(); ++t) {
        const Task& task = plan.tasks[t];
        text += fmt::format("{:2}  {} {}\n", t + 1, task.segment ? "segment" : "task   ", task.name);
        for (const StagePlan& stage : task.stages)
            text += fmt::format("      {:<8} {} ({})\n", form_text(plan, task, stage), stage.name(graph), stage.type(graph));
        if (!task.segment) text += fmt::format("      type     {}\n", graph.nodes[size_t(task.nodes[0])].type->type);
        if (!task.needs.empty()) {
            text += "      after    ";
            for (size_t i = 0; i < task.needs.size(); ++i)
                text += fmt::format("{}{}", i ? ", " : "", task.needs[i] + 1);
            text += "\n";
        }
        for (const Link& link : task.makes)
            text += fmt::format("      makes    {}: {}\n{}", plan.name_of(link),
                                shape_text(plan.shapes[size_t(link.node)][size_t(link.port)]),
                                keys ? fmt::format("      key      {}\n", keys->of(link).text()) : "");
        if (!task.last_uses.empty()) text += fmt::format("      frees    {}\n", joined(plan, task.last_uses));
        if (task.scratch_bytes > 0) text += fmt::format("      scratch  {}\n", bytes_text(task.scratch_bytes));
    }
    if (plan.tasks.empty()) return "nothing to do: no node of this graph writes anything\n";
    text += fmt::format("peak: {} of values and scratch, while '{}' runs\n", bytes_text(plan.peak_bytes),
                        plan.tasks[plan.peak_task].name);
    for (const size_t t : divisible(plan)) text += fmt::format("--shard divides: '{}'\n", plan.tasks[t].name);
    if (keys) text += fmt::format("key of all that is written: {}\n", keys->run.text());
    return text;
}

Json to_json(const Plan& plan, const Keys* keys) {
    const Graph& graph = *plan.graph;
    Json out = Json::object();
    out.set("graph", graph.name);
    Json& tasks = out.set("tasks", Json::list());
    for (const Task& task : plan.tasks) {
        Json one = Json::object();
        one.set("kind", task.segment ? "segment" : "task");
        one.set("name", task.name);
        Json& nodes = one.set("nodes", Json::list());
        for (int n : task.nodes) {
            Json node = Json::object();
            node.set("name", graph.nodes[size_t(n)].name);
            node.set("type", graph.nodes[size_t(n)].type->type);
            nodes.items.push_back(std::move(node));
        }
        Json& fused = one.set("fused", Json::list());
        for (const StagePlan& stage : task.stages)
            if (stage.fusion) {
                Json fusion = Json::object();
                fusion.set("name", stage.name(graph));
                fusion.set("type", stage.type(graph));
                fused.items.push_back(std::move(fusion));
            }
        Json& needs = one.set("after", Json::list());
        for (size_t need : task.needs) needs.items.push_back(Json(std::int64_t(need)));
        Json& makes = one.set("makes", Json::list());
        for (const Link& link : task.makes) {
            const Shape& shape = plan.shapes[size_t(link.node)][size_t(link.port)];
            Json made = Json::object();
            made.set("value", plan.name_of(link));
            if (keys) made.set("key", keys->of(link).text());
            made.set("width", shape.width);
            made.set("height", shape.height);
            made.set("channels", shape.channels);
            made.set("records", shape.records);
            made.set("bytes", shape.bytes);
            makes.items.push_back(std::move(made));
        }
        Json& frees = one.set("frees", Json::list());
        for (const Link& link : task.last_uses) frees.items.push_back(Json(plan.name_of(link)));
        one.set("scratch_bytes", task.scratch_bytes);
        one.set("live_bytes", task.live_bytes);
        tasks.items.push_back(std::move(one));
    }
    out.set("peak_bytes", plan.peak_bytes);
    Json& divided = out.set("divided", Json::list());
    for (const size_t t : divisible(plan)) divided.items.push_back(Json(plan.tasks[t].name));
    if (keys) out.set("key", keys->run.text());
    return out;
}

}  // namespace weft
