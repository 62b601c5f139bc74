// The flattened document of a graph: one level, values filled in, names of written files as they
// were.
#include <fmt/format.h>

#include <cmath>
#include <set>

#include "graph/graph.h"
#include "graph/substitution.h"

namespace weft {

using namespace loading;

namespace {

Json declaration_text(const ParamDecl& decl) {
    Json out = Json::object();
    out.set("type", name_of(decl.kind));
    if (decl.fallback) out.set("default", *decl.fallback);
    if (std::isfinite(decl.minimum)) out.set("minimum", decl.minimum);
    if (std::isfinite(decl.maximum)) out.set("maximum", decl.maximum);
    if (!decl.choices.empty()) {
        std::vector<Json> choices(decl.choices.begin(), decl.choices.end());
        out.set("choices", Json::list(std::move(choices)));
    }
    if (!decl.unit.empty()) out.set("unit", decl.unit);
    if (!decl.about.empty()) out.set("about", decl.about);
    return out;
}

// Parameters that a written file's name is made of.
void note_used(const Json& expression, std::set<std::string>& used) {
    for_each_reference(
        expression, [&](const std::string& name, const Place&) { used.insert(name); },
        [](const std::string&, const Place&) {});
}

}  // namespace

Json Graph::flattened() const {
    const auto link_text = [&](const Link& link) {
        const GraphNode& from = nodes[size_t(link.node)];
        return Json(from.name + "." + from.type->outputs[size_t(link.port)].name);
    };

    std::set<std::string> used;
    Json node_texts = Json::object();
    for (const GraphNode& node : nodes) {
        Json in = Json::object(), set = Json::object();
        for (size_t i = 0; i < node.inputs.size(); ++i) {
            const PortDecl& port = node.type->inputs[i];
            if (node.inputs[i].empty()) continue;
            if (port.need == Need::variadic) {
                std::vector<Json> links;
                for (const Link& link : node.inputs[i]) links.push_back(link_text(link));
                in.set(port.name, Json::list(std::move(links)));
            } else {
                in.set(port.name, link_text(node.inputs[i][0]));
            }
        }
        for (size_t i = 0; i < node.params.size(); ++i) {
            const std::string& param = node.type->params[i].name;
            if (!node.expressions[i].is(Json::Kind::null)) {
                note_used(node.expressions[i], used);
                set.set(param, node.expressions[i]);
            } else if (!node.params[i].is(Json::Kind::null)) {
                set.set(param, escaped(node.params[i]));
            }
        }
        Json text = Json::object();
        text.set("type", fmt::format("{}@{}", node.type->type, node.type->version));
        if (!in.members.empty()) text.set("in", std::move(in));
        if (!set.members.empty()) text.set("set", std::move(set));
        node_texts.set(node.name, std::move(text));
    }

    Json out = Json::object();
    out.set("weft", document_version);
    if (!about.empty()) out.set("about", about);
    Json parameter_texts = Json::object();
    for (const GraphParameter& p : parameters)
        if (used.count(p.decl.name)) parameter_texts.set(p.decl.name, declaration_text(p.decl));
    if (!parameter_texts.members.empty()) out.set("parameters", std::move(parameter_texts));
    out.set("nodes", std::move(node_texts));
    if (!outputs.empty()) {
        Json output_texts = Json::object();
        for (const auto& [port, link] : outputs) output_texts.set(port, link_text(link));
        out.set("outputs", std::move(output_texts));
    }
    return out;
}

}  // namespace weft
