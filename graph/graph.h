// Graph: a document that has been checked, its sub-graphs flattened and its parameters filled in.
// `weft check` and `weft run` both come through load_graph(): what is accepted here can be planned.
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "graph/declaration.h"
#include "graph/diagnostic.h"

namespace weft {

constexpr int document_version = 1;

struct Link {
    int node = -1, port = -1;  // an output of graph.nodes[node]
};

struct GraphNode {
    std::string name;  // "pass-1/cluster" inside a sub-graph
    const NodeDecl* type = nullptr;
    std::vector<Json> params;  // as type->params, defaults filled in; null: not set
    // As params: text with the top document's "$name"s kept, for files written and for what has no
    // value yet; null elsewhere.
    std::vector<Json> expressions;
    std::vector<std::vector<Link>> inputs;  // as type->inputs
    Place place;                            // its name in the document
};

struct GraphParameter {
    ParamDecl decl;
    Json value;  // null: neither set nor defaulted
};

struct Graph {
    std::string name;  // the document's path
    std::string about;
    std::vector<GraphParameter> parameters;  // of the top document
    std::vector<GraphNode> nodes;            // every node after those it reads from
    std::map<std::string, Link> outputs;     // of a document that declares outputs

    int find(std::string_view node) const;  // index by name, or -1

    // The flattened document: one level, names kept, parameters as values except those in the names
    // of files written. It parses again to the same graph, whatever --set gave for files written.
    Json flattened() const;
};

// Changes asked for on the command line, in order of application: swap, bypass, set.
struct Overrides {
    std::vector<std::string> set;     // "locations=64", "filter.radius=2", "pass-1/cluster.box=30"
    std::vector<std::string> swap;    // "cluster=depth-gap-cluster,gap=0.1"
    std::vector<std::string> bypass;  // "smooth"
};

struct LoadOptions {
    Overrides overrides;
    bool for_run = false;  // parameters without a value are errors (else: some value of their type)
};

struct Loaded {
    Graph graph;                       // meaningful if there are no errors
    std::vector<Diagnostic> findings;  // by place
    bool ok() const { return !has_errors(findings); }
};

Loaded load_graph(const std::string& path, const Catalog& catalog, const LoadOptions& options = {});
// The same from text; `name` stands for the file in messages, its folder is where sub-graphs are
// looked for.
Loaded load_graph_text(std::string text, const std::string& name, const Catalog& catalog,
                       const LoadOptions& options = {});

// JSON Schema (draft 2020-12) of graph documents, with every node type of the catalog.
Json graph_schema(const Catalog& catalog);

// Graphviz and Mermaid text of a graph: sub-graphs as clusters, streams dashed.
std::string to_dot(const Graph& graph);
std::string to_mermaid(const Graph& graph);

}  // namespace weft
