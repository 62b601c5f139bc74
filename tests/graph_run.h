// Runs a graph from its text, beside the shipped graphs, and looks at the picture that it writes.
#pragma once
#include "image/picture_file.h"
#include "runtime/run.h"
#include "tests/run_node.h"

namespace weft {

// Runs a graph's text; gives the picture that it writes to the file called OUT in it.
struct GraphRun {
    TestFolder folder;
    RunResult result;
    std::vector<std::string> warnings;
    Image picture;

    // `set` are graph parameters, as in weft run --set.
    GraphRun(std::string text, int tile = 32, int threads = 1, bool fuse = true, std::vector<std::string> set = {}) {
        const std::string out = folder / "out.exr";
        const auto put_out = [&](std::string& in) {
            for (size_t at; (at = in.find("OUT")) != std::string::npos;) in.replace(at, 3, out);
        };
        put_out(text);
        for (std::string& s : set) put_out(s);
        LoadOptions load;
        load.for_run = true;
        load.overrides.set = std::move(set);
        const Loaded loaded = load_graph_text(text, std::string(WEFT_SOURCE_DIR) + "/graphs/test.json", Registry::instance(), load);
        for (const Diagnostic& finding : loaded.findings)
            if (finding.level == Diagnostic::Level::error) ADD_FAILURE() << to_text(finding);
        if (!loaded.ok()) return;
        RunOptions options;
        options.tile = tile;
        Monitor monitor;
        monitor.warning = [&](const std::string& node, const std::string& message) { warnings.push_back(node + ": " + message); };
        PlanOptions plan;
        plan.fuse = fuse;
        result = run_plan(make_plan(loaded.graph, plan), *make_thread_executor(threads), monitor, options);
        for (const NodeError& error : result.errors) ADD_FAILURE() << error.node << ": " << error.message;
        if (result.ok()) picture = read_picture(out);
    }
};

inline std::vector<float> values_of(const Image& image) { return {image.pixels().begin(), image.pixels().end()}; }

}  // namespace weft
