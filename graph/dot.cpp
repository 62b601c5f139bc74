// Pictures of a graph as text for Graphviz and Mermaid.
#include <fmt/format.h>

#include <map>
#include <memory>

#include "graph/graph.h"

namespace weft {
namespace {

// The nodes of one sub-graph, and those of the sub-graphs in it.
struct Cluster {
    std::vector<size_t> nodes;
    std::map<std::string, std::unique_ptr<Cluster>, std::less<>> inner;
};

Cluster clusters(const Graph& graph) {
    Cluster top;
    for (size_t i = 0; i < graph.nodes.size(); ++i) {
        Cluster* cluster = &top;
        std::string_view rest = graph.nodes[i].name;
        for (size_t slash; (slash = rest.find('/')) != std::string_view::npos;
             rest.remove_prefix(slash + 1)) {
            auto& inner = cluster->inner[std::string(rest.substr(0, slash))];
            if (!inner) inner = std::make_unique<Cluster>();
            cluster = inner.get();
        }
        cluster->nodes.push_back(i);
    }
    return top;
}

std::string_view own_name(const GraphNode& node) {
    const size_t slash = node.name.rfind('/');
    return std::string_view(node.name).substr(slash == std::string::npos ? 0 : slash + 1);
}

const PortDecl& output_of(const Graph& graph, const Link& link) {
    return graph.nodes[size_t(link.node)].type->outputs[size_t(link.port)];
}

// Texts come of documents and of third parties' nodes: whatever could end a label is made harmless.
std::string dot_text(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c == '\n' ? ' ' : c;
    }
    return out;
}

std::string mermaid_text(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c == '"')
            out += "#quot;";
        else
            out += c == '\n' ? ' ' : c;
    }
    return out;
}

void dot_cluster(const Graph& graph, const Cluster& cluster, const std::string& path, int depth,
                 std::string& out) {
    const std::string indent(size_t(2 * depth), ' ');
    for (const size_t i : cluster.nodes) {
        const GraphNode& node = graph.nodes[i];
        out += fmt::format("{}n{} [label=\"{}\\n{}\"{}];\n", indent, i, dot_text(own_name(node)),
                           dot_text(node.type->type), node.type->writes ? ", penwidth=2" : "");
    }
    for (const auto& [name, inner] : cluster.inner) {
        const std::string inner_path = path.empty() ? name : path + "/" + name;
        out += fmt::format("{}subgraph \"cluster_{}\" {{\n{}  label=\"{}\";\n", indent,
                           dot_text(inner_path), indent, dot_text(name));
        dot_cluster(graph, *inner, inner_path, depth + 1, out);
        out += indent + "}\n";
    }
}

void mermaid_cluster(const Graph& graph, const Cluster& cluster, int depth, int& count,
                     std::string& out) {
    const std::string indent(size_t(2 * depth), ' ');
    for (const size_t i : cluster.nodes) {
        const GraphNode& node = graph.nodes[i];
        out += fmt::format("{}n{}[\"{}<br/>{}\"]\n", indent, i, mermaid_text(own_name(node)),
                           mermaid_text(node.type->type));
    }
    for (const auto& [name, inner] : cluster.inner) {
        out += fmt::format("{}subgraph s{}[\"{}\"]\n", indent, count++, mermaid_text(name));
        mermaid_cluster(graph, *inner, depth + 1, count, out);
        out += indent + "end\n";
    }
}

template <class Visit>
void each_link(const Graph& graph, Visit&& visit) {
    for (size_t i = 0; i < graph.nodes.size(); ++i)
        for (const auto& port : graph.nodes[i].inputs)
            for (const Link& link : port) visit(i, link);
}

}  // namespace

std::string to_dot(const Graph& graph) {
    std::string out =
        "digraph weft {\n  rankdir=LR;\n  node [shape=box, style=rounded, "
        "fontname=\"sans-serif\"];\n"
        "  edge [fontname=\"sans-serif\", fontsize=10];\n";
    dot_cluster(graph, clusters(graph), "", 1, out);
    each_link(graph, [&](size_t node, const Link& link) {
        const PortDecl& port = output_of(graph, link);
        out += fmt::format("  n{} -> n{} [label=\"{}\"{}];\n", link.node, node, dot_text(port.type),
                           port.stream ? ", style=dashed" : "");
    });
    size_t count = 0;
    for (const auto& [name, link] : graph.outputs) {
        out += fmt::format("  o{} [label=\"{}\", shape=ellipse];\n", count, dot_text(name));
        out += fmt::format("  n{} -> o{} [label=\"{}\"{}];\n", link.node, count++,
                           dot_text(output_of(graph, link).type),
                           output_of(graph, link).stream ? ", style=dashed" : "");
    }
    return out + "}\n";
}

std::string to_mermaid(const Graph& graph) {
    std::string out = "flowchart LR\n";
    int count = 0;
    mermaid_cluster(graph, clusters(graph), 1, count, out);
    const auto arrow = [](const PortDecl& port) { return port.stream ? "-.->" : "-->"; };
    each_link(graph, [&](size_t node, const Link& link) {
        const PortDecl& port = output_of(graph, link);
        out += fmt::format("  n{} {}|\"{}\"| n{}\n", link.node, arrow(port),
                           mermaid_text(port.type), node);
    });
    size_t output = 0;
    for (const auto& [name, link] : graph.outputs) {
        const PortDecl& port = output_of(graph, link);
        out += fmt::format("  o{}([\"{}\"])\n", output, mermaid_text(name));
        out += fmt::format("  n{} {}|\"{}\"| o{}\n", link.node, arrow(port),
                           mermaid_text(port.type), output++);
    }
    return out;
}

}  // namespace weft
