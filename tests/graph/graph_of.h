// Short words for the tests of graphs.
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "catalog.h"
#include "graph/graph.h"

namespace weft::test {

inline const TestCatalog& catalog() {
    static const TestCatalog catalog;
    return catalog;
}

inline Loaded load(const std::string& text, const LoadOptions& options = {},
                   const std::string& name = "test.json") {
    return load_graph_text(text, name, catalog(), options);
}

inline std::string all_text(const std::vector<Diagnostic>& findings) {
    std::string out;
    for (const Diagnostic& finding : findings) out += to_text(finding) + "\n";
    return out;
}

// "place: message" of each finding, a line each.
inline std::string short_text(const std::vector<Diagnostic>& findings) {
    std::string out;
    for (const Diagnostic& finding : findings)
        out += where(finding.place) + ": " + finding.message + "\n";
    return out;
}

// The graph of a text that must be in order.
inline Graph graph_of(const std::string& text, const LoadOptions& options = {},
                      const std::string& name = "test.json") {
    Loaded loaded = load(text, options, name);
    EXPECT_EQ(all_text(loaded.findings), "");
    return std::move(loaded.graph);
}

inline Json param(const Graph& graph, std::string_view node, std::string_view name) {
    const int index = graph.find(node);
    if (index < 0) return Json("no such node");
    const GraphNode& n = graph.nodes[size_t(index)];
    for (size_t i = 0; i < n.params.size(); ++i)
        if (n.type->params[i].name == name) return n.params[i];
    return Json("no such parameter");
}

// What is linked to an input: "a.b c.d".
inline std::string sources(const Graph& graph, std::string_view node, std::string_view port) {
    const int index = graph.find(node);
    if (index < 0) return "no such node";
    const GraphNode& n = graph.nodes[size_t(index)];
    const int p = n.type->find_input(port);
    if (p < 0) return "no such input";
    std::string out;
    for (const Link& link : n.inputs[size_t(p)]) {
        const GraphNode& from = graph.nodes[size_t(link.node)];
        out +=
            (out.empty() ? "" : " ") + from.name + "." + from.type->outputs[size_t(link.port)].name;
    }
    return out;
}

inline std::string names(const Graph& graph) {
    std::string out;
    for (const GraphNode& node : graph.nodes) out += (out.empty() ? "" : " ") + node.name;
    return out;
}

// A folder of its own, removed at the end.
class Folder {
  public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "weft-graph-XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    std::string write(const std::string& name, const std::string& text) const {
        const std::filesystem::path file = path_ / name;
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file) << text;
        return file.string();
    }
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }

  private:
    std::filesystem::path path_;
};

}  // namespace weft::test
