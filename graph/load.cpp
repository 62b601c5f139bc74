// load_graph: the passes over a document, one after another, and the graph that comes of them.
#include <set>

#include "graph/expand.h"
#include "graph/graph.h"
#include "graph/library.h"
#include "graph/table.h"

namespace weft {

using namespace loading;

namespace {

PortTypes port_types(const Catalog& catalog) {
    PortTypes types;
    for (const NodeDecl* decl : catalog.all())
        for (const auto* ports : {&decl->inputs, &decl->outputs})
            for (const PortDecl& port : *ports) types[port.type] = port.stream;
    return types;
}

// A file to write that only an option named: the flattened document has a parameter for it, so that
// its text does not depend on the option.
void invent_parameters(Graph& graph) {
    std::set<std::string> names;
    for (const GraphParameter& p : graph.parameters) names.insert(p.decl.name);
    for (GraphNode& node : graph.nodes) {
        for (size_t i = 0; i < node.params.size(); ++i) {
            const ParamDecl& param = node.type->params[i];
            if (param.use != FileUse::write || node.params[i].is(Json::Kind::null) ||
                !node.expressions[i].is(Json::Kind::null))
                continue;
            std::string name = node.name + "-" + param.name;
            for (char& c : name)
                if (c == '/') c = '-';
            while (!names.insert(name).second) name += "-file";
            ParamDecl decl;
            decl.name = name;
            decl.kind = param.kind;
            decl.about = param.about;
            decl.optional_file = param.optional_file;
            graph.parameters.push_back({std::move(decl), node.params[i]});
            node.expressions[i] = Json(fmt::format("${}", name));
        }
    }
}

void build(NodeTable& table, const std::vector<int>& order, Graph& graph) {
    std::vector<int> index(table.nodes.size(), -1);
    for (const int node : order) {
        if (table.nodes[size_t(node)].stand_in) continue;
        index[size_t(node)] = int(graph.nodes.size());
        FlatNode& flat = table.nodes[size_t(node)];
        GraphNode& out = graph.nodes.emplace_back();
        out.name = std::move(flat.name);
        out.type = flat.type;
        out.params = std::move(flat.params);
        out.expressions = std::move(flat.expressions);
        out.place = flat.place;
        for (const auto& port : flat.inputs) {
            auto& links = out.inputs.emplace_back();
            for (const FlatLink& link : port)
                if (const int from = index[size_t(link.link.node)]; from >= 0)
                    links.push_back({from, link.link.port});
        }
    }
    for (const auto& [name, link] : table.outputs)
        if (index[size_t(link.node)] >= 0)
            graph.outputs[name] = {index[size_t(link.node)], link.port};
    graph.parameters = std::move(table.parameters);
    invent_parameters(graph);
}

Loaded load(NodeTable& table, Library& library, const Document& top, const LoadOptions& options,
            Findings& findings) {
    Loaded loaded;
    loaded.graph.name = top.source->name;
    loaded.graph.about = top.about;
    Options changes = take_options(options.overrides, findings);
    if (top.readable) {
        Expander(table, library, changes, options.for_run, findings).run(top);
        connect(table, options.for_run, findings);
        const std::vector<int> nodes = order(table, findings);
        find_unread(table, findings);
        check_streams(table, nodes, findings);
        build(table, nodes, loaded.graph);
    }
    loaded.findings = findings.sorted();
    return loaded;
}

}  // namespace

Loaded load_graph(const std::string& path, const Catalog& catalog, const LoadOptions& options) {
    Findings findings;
    NodeTable table;
    table.catalog = &catalog;
    table.types = port_types(catalog);
    Library library(table, findings);
    std::string problem;
    if (const Document* top = library.file(path, problem))
        return load(table, library, *top, options, findings);
    Loaded loaded;
    loaded.graph.name = path;
    const auto source = std::make_shared<const Source>(Source{path, ""});
    findings.error({source}, "cannot read the graph: {}", problem);
    loaded.findings = findings.sorted();
    return loaded;
}

Loaded load_graph_text(std::string text, const std::string& name, const Catalog& catalog,
                       const LoadOptions& options) {
    Findings findings;
    NodeTable table;
    table.catalog = &catalog;
    table.types = port_types(catalog);
    Library library(table, findings);
    const Document& top = library.text(std::move(text), name);
    return load(table, library, top, options, findings);
}

int Graph::find(std::string_view node) const {
    for (size_t i = 0; i < nodes.size(); ++i)
        if (nodes[i].name == node) return int(i);
    return -1;
}

}  // namespace weft
