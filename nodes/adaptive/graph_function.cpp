#include "adaptive/graph_function.h"

#include <fmt/format.h>

#include <filesystem>

#include "runtime/registry.h"

namespace weft::adaptive {
namespace {

// The document as a node, with the points linked to it.
std::string around(const std::string& file, const Json& set) {
    Json points = Json::object(), call = Json::object(), links = Json::object(),
         nodes = Json::object(), outputs = Json::object(), document = Json::object();
    points.set("type", "asked-points");
    links.set("points", "points");
    call.set("type", fmt::format("./{}", std::filesystem::path(file).filename().string()));
    call.set("in", std::move(links));
    if (!set.members.empty()) call.set("set", set);
    nodes.set("points", std::move(points));
    nodes.set("function", std::move(call));
    outputs.set("samples", "function.samples");
    document.set("weft", 1);
    document.set("outputs", std::move(outputs));
    document.set("nodes", std::move(nodes));
    return document.dump(true);
}

}  // namespace

GraphFunction::GraphFunction(const std::string& file, const Json& set, Context& ctx) {
    const Registry& registry = Registry::instance();
    LoadOptions options;
    options.for_run = true;
    const std::string name = (std::filesystem::path(file).parent_path() / "graph-sampler").string();
    Loaded loaded = load_graph_text(around(file, set), name, registry, options);
    std::string findings;
    for (const Diagnostic& finding : loaded.findings)
        if (finding.level == Diagnostic::Level::error)
            findings += fmt::format("\n{}", to_text(finding));
    if (!findings.empty())
        throw Error(
            fmt::format("'{}' is no function of points; expected a graph with an input "
                        "\"points\" and an output \"samples\", both Samples:{}",
                        file, findings));
    graph_ = std::move(loaded.graph);
    points_ = size_t(graph_.find("points"));
    output_ = graph_.outputs.at("samples");
    asked_.resize(graph_.nodes.size());
    constant_.resize(graph_.nodes.size());
    for (size_t n = 0; n < graph_.nodes.size(); ++n) {
        const GraphNode& node = graph_.nodes[n];
        instances_.push_back(registry.type(node.type->type)->make(node.params));
        asked_[n] = n == points_;
        for (const auto& links : node.inputs)
            for (const Link& link : links) asked_[n] = asked_[n] || asked_[size_t(link.node)];
        if (instances_.back()->form() != Form::value)
            throw Error(
                fmt::format("'{}': node '{}' works on a stream; a function of points is "
                            "made of nodes that work on whole values",
                            file, node.name));
        if (!asked_[n]) run(n, constant_, ctx);
    }
    if (!asked_[size_t(output_.node)])
        throw Error(fmt::format("'{}': its output does not depend on its points", file));
}

Samples GraphFunction::operator()(const Samples& points) const {
    Values values = constant_;
    PlainContext ctx;
    for (size_t n = 0; n < graph_.nodes.size(); ++n) {
        if (n == points_)
            values[n] = {std::make_shared<Samples>(points)};
        else if (asked_[n])
            run(n, values, ctx);
    }
    return *static_cast<const Samples*>(values[size_t(output_.node)][size_t(output_.port)].get());
}

void GraphFunction::run(size_t n, Values& values, Context& ctx) const {
    const GraphNode& node = graph_.nodes[n];
    Inputs in;
    for (size_t port = 0; port < node.inputs.size(); ++port) {
        Slot slot{node.type->inputs[port].name,
                  Registry::instance().type_info(node.type->inputs[port].type),
                  nullptr,
                  {}};
        std::vector<std::string> names;
        for (const Link& link : node.inputs[port]) {
            slot.more.push_back(values[size_t(link.node)][size_t(link.port)].get());
            names.push_back(graph_.nodes[size_t(link.node)].name);
        }
        if (slot.more.empty()) continue;
        slot.object = slot.more.front();
        in.linked.emplace_back(node.type->inputs[port].name, std::move(names));
        in.slots.push_back(std::move(slot));
    }
    Outputs out;
    values[n].clear();
    for (const PortDecl& port : node.type->outputs) {
        const TypeInfo* type = Registry::instance().type_info(port.type);
        values[n].push_back(type->make());
        out.slots.push_back({port.name, type, values[n].back().get(), {}});
    }
    try {
        instances_[n]->run(in, out, ctx);
    } catch (const Cancelled&) {
        throw;
    } catch (const Error& error) {
        throw Error(fmt::format(
            "{}: node '{}': {}",
            graph_.nodes[n].place.source ? graph_.nodes[n].place.source->name : graph_.name,
            node.name, error.what()));
    }
}

}  // namespace weft::adaptive
