// nodes, node, schema: what node types there are and what they say of themselves.
#include <fmt/format.h>

#include <cmath>

#include "cli/commands.h"
#include "cli/terminal.h"
#include "runtime/plan.h"
#include "runtime/registry.h"

namespace weft::cli {
namespace {

std::string range_text(const ParamDecl& p) {
    std::string text = fmt::format("{}", fmt::join(p.choices, " | "));
    const bool low = std::isfinite(p.minimum), high = std::isfinite(p.maximum);
    if (low && high) text = fmt::format("{:g} to {:g}", p.minimum, p.maximum);
    else if (low) text = fmt::format("at least {:g}", p.minimum);
    else if (high) text = fmt::format("at most {:g}", p.maximum);
    if (!p.unit.empty()) text += (text.empty() ? "" : " ") + p.unit;
    return text;
}

std::string need_text(const PortDecl& port) {
    std::vector<std::string> words;
    if (port.stream) words.push_back("stream");
    if (port.need == Need::optional) words.push_back("optional");
    if (port.need == Need::variadic) words.push_back("any number");
    if (port.selects) words.push_back("a selection of the records");
    if (port.branch) words.push_back("may be a selection");
    return words.empty() ? "" : fmt::format(" ({})", fmt::join(words, ", "));
}

void add_ports(std::string& text, const char* title, const std::vector<PortDecl>& ports) {
    if (ports.empty()) return;
    text += fmt::format("\n{}\n", title);
    for (const PortDecl& port : ports)
        text += fmt::format("  {:<14} {}{}\n{:17}{}\n", port.name, port.type, need_text(port), "", port.about);
}

Json port_json(const PortDecl& port) {
    Json one = Json::object();
    one.set("name", port.name);
    one.set("type", port.type);
    one.set("stream", port.stream);
    one.set("need", port.need == Need::required ? "required" : port.need == Need::optional ? "optional" : "variadic");
    one.set("about", port.about);
    return one;
}

Json param_json(const ParamDecl& p) {
    Json one = Json::object();
    one.set("name", p.name);
    one.set("kind", std::string(name_of(p.kind)));
    if (p.fallback) one.set("default", *p.fallback);
    if (std::isfinite(p.minimum)) one.set("minimum", p.minimum);
    if (std::isfinite(p.maximum)) one.set("maximum", p.maximum);
    if (!p.unit.empty()) one.set("unit", p.unit);
    if (!p.choices.empty()) {
        Json& choices = one.set("choices", Json::list());
        for (const std::string& choice : p.choices) choices.items.push_back(Json(choice));
    }
    one.set("about", p.about);
    return one;
}

Json decl_json(const NodeDecl& decl) {
    Json one = Json::object();
    one.set("type", decl.type);
    one.set("version", decl.version);
    one.set("family", decl.family);
    one.set("about", decl.about);
    one.set("writes", decl.writes);
    Json inputs = Json::list(), outputs = Json::list(), params = Json::list();
    for (const PortDecl& port : decl.inputs) inputs.items.push_back(port_json(port));
    for (const PortDecl& port : decl.outputs) outputs.items.push_back(port_json(port));
    for (const ParamDecl& p : decl.params) params.items.push_back(param_json(p));
    one.set("inputs", std::move(inputs));
    one.set("outputs", std::move(outputs));
    one.set("parameters", std::move(params));
    return one;
}

std::vector<std::string> families() {
    std::vector<std::string> names;
    for (const NodeDecl* decl : Registry::instance().all())
        if (names.empty() || names.back() != decl->family) names.push_back(decl->family);
    return names;
}

}  // namespace

int nodes(const std::string& family, bool json) {
    std::string text, last;
    Json all = Json::list();
    for (const NodeDecl* decl : Registry::instance().all()) {
        if (!family.empty() && decl->family != family) continue;
        all.items.push_back(decl_json(*decl));
        if (decl->family != last) text += fmt::format("{}{}\n", last.empty() ? "" : "\n", decl->family);
        last = decl->family;
        text += fmt::format("  {:<24} {}\n", decl->type, decl->about.substr(0, decl->about.find('\n')));
    }
    if (text.empty()) throw UsageError(fmt::format("no node family '{}'{}", family, suggestion(family, families())));
    print(json ? all.dump(true) + "\n" : text);
    return done;
}

int node(const std::string& type, bool json) {
    const NodeDecl* decl = Registry::instance().find(type);
    if (!decl) {
        if (const std::string_view option = Registry::instance().option_of(type); !option.empty())
            throw UsageError(fmt::format("no node type '{}': this build was made without it; configure with -D{}=ON", type, option));
        std::vector<std::string> names;
        for (const NodeDecl* other : Registry::instance().all()) names.push_back(other->type);
        throw UsageError(fmt::format("no node type '{}'{}; 'weft nodes' lists all", type, suggestion(type, names)));
    }
    if (json) {
        print(decl_json(*decl).dump(true) + "\n");
        return done;
    }
    std::string text = fmt::format("{} (version {}, {})\n{}\n", decl->type, decl->version, decl->family, decl->about);
    add_ports(text, "in", decl->inputs);
    add_ports(text, "out", decl->outputs);
    if (!decl->params.empty()) text += "\nset\n";
    for (const ParamDecl& p : decl->params) {
        const std::string fallback = p.fallback ? "default " + p.fallback->dump() : "must be set";
        const std::string range = range_text(p);
        text += fmt::format("  {:<14} {}, {}{}\n{:17}{}\n", p.name, name_of(p.kind), fallback,
                            range.empty() ? "" : ", " + range, "", p.about);
    }
    print(text);
    return done;
}

int schema() {
    print(graph_schema(Registry::instance()).dump(true) + "\n");
    return done;
}

}  // namespace weft::cli
