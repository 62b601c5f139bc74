// What the fuzzer and the replay of its corpus do with one input. The text up to the first line
// "--" is the document; each line after it is an option: "set x=1", "swap a=b", "bypass a", "run".
#pragma once
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "../graph/catalog.h"
#include "graph/graph.h"

namespace weft::test {

[[noreturn]] inline void fail(const char* what, const std::string& text) {
    std::fprintf(stderr, "%s\n%s\n", what, text.c_str());
    std::abort();
}

inline void fuzz_graph(std::string_view input) {
    static const TestCatalog catalog;
    LoadOptions options;
    const size_t cut = input.find("\n--\n");
    std::string_view rest = cut == std::string_view::npos ? "" : input.substr(cut + 4);
    while (!rest.empty()) {
        const std::string_view line = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(rest.size(), line.size() + 1));
        if (line.starts_with("set ")) options.overrides.set.emplace_back(line.substr(4));
        if (line.starts_with("swap ")) options.overrides.swap.emplace_back(line.substr(5));
        if (line.starts_with("bypass ")) options.overrides.bypass.emplace_back(line.substr(7));
        if (line == "run") options.for_run = true;
    }
    // Graphs used as nodes are looked for beside this name, where there are none.
    const Loaded loaded =
        load_graph_text(std::string(input.substr(0, cut)), "/nowhere/fuzz.json", catalog, options);
    size_t told = 0;
    for (const Diagnostic& finding : loaded.findings) told += to_text(finding).size();
    if (!loaded.ok()) {
        if (told == 0) fail("an error without a word", std::string(input));
        return;
    }
    to_dot(loaded.graph);
    to_mermaid(loaded.graph);
    // Inputs that nobody feeds are not in a flattened document; all others read back the same.
    for (const GraphNode& node : loaded.graph.nodes)
        for (size_t i = 0; i < node.inputs.size(); ++i)
            if (node.type->inputs[i].need != Need::optional && node.inputs[i].empty()) return;
    const std::string flat = loaded.graph.flattened().dump();
    const Loaded again = load_graph_text(flat, "/nowhere/flat.json", catalog);
    for (const Diagnostic& finding : again.findings)
        if (finding.level == Diagnostic::Level::error)
            fail("flattened, it is refused", to_text(finding) + "\n" + flat);
    if (again.graph.flattened().dump() != flat) fail("flattened twice, it is another", flat);
}

}  // namespace weft::test
