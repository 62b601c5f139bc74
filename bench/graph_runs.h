// Graphs that benchmark programs run, and tables of what their runs cost.
#pragma once
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/registry.h"
#include "runtime/run.h"

namespace weft {

// A folder in memory, for as long as this lives.
struct Scratch {
    std::string path;
    Scratch() {
        std::string name = "/dev/shm/weft-bench.XXXXXX";
        if (!mkdtemp(name.data())) throw Error("cannot make a folder in /dev/shm");
        path = name;
    }
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
};

// The graph of a file, from the project's folder, with parameters as of --set.
inline Graph graph_of(const std::string& file, std::vector<std::string> set) {
    LoadOptions load;
    load.for_run = true;
    load.overrides.set = std::move(set);
    Loaded loaded =
        load_graph(std::filesystem::path(WEFT_SOURCE_DIR) / file, Registry::instance(), load);
    if (!loaded.ok()) throw Error(to_text(loaded.findings.at(0)));
    return std::move(loaded.graph);
}

inline RunResult run(const Graph& graph, int threads) {
    Monitor monitor;
    RunResult result = run_plan(make_plan(graph), *make_tbb_executor(threads), monitor);
    if (!result.ok()) throw Error(result.errors.at(0).message);
    return result;
}

// CPU nanoseconds a location of each node and stage.
inline void print_nodes(const RunResult& result, double locations) {
    const auto one = [&](const StageReport& stage) {
        const double ns = stage.cpu_s * 1e9 / locations;
        if (ns >= 0.05)
            fmt::print("    {:48} {:8.1f} ns\n", stage.name + " (" + stage.type + ")", ns);
    };
    for (const StageReport& node : result.nodes) one(node);
    for (const SegmentReport& segment : result.segments)
        for (const StageReport& stage : segment.stages) one(stage);
}

// One row a value of what is scaled, each four times the one before: CPU seconds of the whole run
// and of the reconstruction, and how these compare with the first row's, scaled.
struct Series {
    const char* what;
    double cpu_s = 0, stages_s = 0, factor = 1;
    void add(const std::string& label, double run, double stages) {
        if (cpu_s == 0) {
            cpu_s = run;
            stages_s = stages;
            fmt::print("{:12} {:>9} {:>9} {:>12} {:>12}\n", what, "run s", "stages s", "run/linear",
                       "stages/linear");
        }
        fmt::print("{:12} {:9.3f} {:9.3f} {:12.2f} {:12.2f}\n", label, run, stages,
                   run / (cpu_s * factor), stages / (stages_s * factor));
        factor *= 4;
    }
};

}  // namespace weft
