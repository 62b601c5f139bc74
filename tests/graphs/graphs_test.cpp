// Every graph in graphs/ runs as it is, at a small size, and gives the same bytes however it is run.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "runtime/provenance.h"
#include "runtime/registry.h"
#include "runtime/run.h"
#include "runtime/shard.h"

namespace weft {
namespace {
namespace fs = std::filesystem;

std::string slurp(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

// A build without random parameter filtering cannot run its graphs.
std::vector<fs::path> shipped_graphs() {
    const bool has_rpf = Registry::instance().type("build-vectors") != nullptr;
    std::vector<fs::path> graphs;
    for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(WEFT_SOURCE_DIR) / "graphs"))
        if (entry.path().extension() == ".json" && (has_rpf || !entry.path().filename().string().starts_with("rpf"))) graphs.push_back(entry.path());
    std::sort(graphs.begin(), graphs.end());
    return graphs;
}

// Values that make a run small, for those of these parameters that a graph has.
const std::map<std::string, std::string> small_values = {
    {"width", "48"}, {"height", "27"}, {"spp", "2"}, {"locations", "6"}, {"trials", "6"}, {"reference-spp", "4"}, {"y", "13"}, {"row", "13"},
};

// A small buffer of the built-in scene, made once.
std::string small_samples() {
    static const std::string file = [] {
        const std::string path = (fs::path(testing::TempDir()) / "weft-graphs" / "garden-48x27.npz").string();
        const Loaded loaded = load_graph_text(
            R"({"weft": 1, "nodes": {
                "make": {"type": "analytic-samples", "set": {"width": 48, "height": 27, "spp": 1}},
                "write": {"type": "write-samples", "in": {"samples": "make"}, "set": {"file": ")" + path + R"("}}}})",
            "small.json", Registry::instance());
        const Plan plan = make_plan(loaded.graph);
        Monitor monitor;
        EXPECT_TRUE(run_plan(plan, *make_serial_executor(), monitor).ok());
        return path;
    }();
    return file;
}

Overrides small(const fs::path& graph, const fs::path& out) {
    Overrides overrides;
    const Loaded loaded = load_graph(graph.string(), Registry::instance());
    for (const GraphParameter& parameter : loaded.graph.parameters) {
        const std::string& name = parameter.decl.name;
        if (const auto known = small_values.find(name); known != small_values.end() && mismatch(parameter.decl, parse_json_or_throw(known->second, name)).empty())
            overrides.set.push_back(name + "=" + known->second);
        if (name == "samples") overrides.set.push_back("samples=" + small_samples());
        if (name == "samples-out") overrides.set.push_back("samples-out=" + (out / "samples.npz").string());
        if (name == "out") overrides.set.push_back("out=" + (out / "picture.exr").string());
    }
    return overrides;
}

std::map<std::string, std::string> files_in(const fs::path& folder) {
    std::map<std::string, std::string> files;
    if (fs::exists(folder))
        for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
            if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = slurp(entry.path());
    return files;
}

// All files that a run leaves in its folder, by name.
std::map<std::string, std::string> run(const fs::path& graph, const std::string& label, Executor& executor, int tile) {
    const fs::path out = fs::path(testing::TempDir()) / "weft-graphs" / graph.stem() / label;
    fs::remove_all(out);
    LoadOptions load;
    load.for_run = true;
    load.overrides = small(graph, out);
    const Loaded loaded = load_graph(graph.string(), Registry::instance(), load);
    for (const Diagnostic& finding : loaded.findings) ADD_FAILURE() << to_text(finding);
    if (!loaded.ok()) return {};
    const Plan plan = make_plan(loaded.graph);
    Monitor monitor;
    RunOptions options;
    options.tile = tile;
    options.provenance = make_provenance(plan);
    const RunResult result = run_plan(plan, executor, monitor, options);
    for (const NodeError& error : result.errors) ADD_FAILURE() << error.node << ": " << error.message;
    return files_in(out);
}

// The same of a run in shards and their merge.
std::map<std::string, std::string> run_in_shards(const Graph& graph, const fs::path& out, int shards, Executor& executor, int tile) {
    fs::remove_all(out);
    const fs::path parts_folder = out.string() + "-parts";
    std::vector<std::string> files;
    PlanOptions plan_options;
    plan_options.work = Work::shard;
    const Plan plan = make_plan(graph, plan_options);
    const auto expect_ok = [](const RunResult& result) {
        for (const NodeError& error : result.errors) ADD_FAILURE() << error.node << ": " << error.message;
    };
    for (int i = 1; i <= shards; ++i) {
        files.push_back((parts_folder / std::to_string(i)).string());
        PartHeader header = shard_header(plan, files_read(plan), {i, shards}, tile);
        PartWriter part(files.back());
        Monitor monitor;
        RunOptions options;
        options.tile = tile;
        options.provenance = header.provenance;
        options.shard = header.shard;
        options.part = &part;
        const RunResult result = run_plan(plan, executor, monitor, options);
        expect_ok(result);
        header.tasks = result.divided;
        part.finish(header);
    }
    EXPECT_TRUE(files_in(out).empty()) << "a shard wrote more than its part";

    const Parts parts(files);
    LoadOptions load;
    load.for_run = true;
    for (const auto& [name, value] : parts.header().files) load.overrides.set.push_back(name + "=" + value);
    const Loaded loaded = load_graph_text(parts.header().provenance.graph, "part", Registry::instance(), load);
    for (const Diagnostic& finding : loaded.findings) ADD_FAILURE() << to_text(finding);
    const Plan merge = make_plan(loaded.graph, merge_options(parts.header()));
    Monitor monitor;
    RunOptions options;
    options.tile = tile;
    options.provenance = parts.header().provenance;
    options.parts = &parts;
    expect_ok(run_plan(merge, executor, monitor, options));
    fs::remove_all(parts_folder);
    return files_in(out);
}

class ShippedGraph : public testing::TestWithParam<fs::path> {};

TEST_P(ShippedGraph, SaysWhatItIs) {
    const Loaded loaded = load_graph(GetParam().string(), Registry::instance());
    for (const Diagnostic& finding : loaded.findings) ADD_FAILURE() << to_text(finding);
    EXPECT_GE(loaded.graph.about.size(), 20u);
    for (const GraphParameter& parameter : loaded.graph.parameters) {
        EXPECT_TRUE(parameter.decl.fallback) << parameter.decl.name << " has no default, so the graph does not run as it is";
        EXPECT_FALSE(parameter.decl.about.empty()) << parameter.decl.name;
    }
}

TEST_P(ShippedGraph, GivesTheSameBytesForAnyThreadsAndTiles) {
    const auto first = run(GetParam(), "one", *make_tbb_executor(1), 32);
    ASSERT_FALSE(first.empty()) << "no file was written";
    for (const auto& [name, bytes] : first) EXPECT_GT(bytes.size(), 0u) << name;
    EXPECT_EQ(run(GetParam(), "two", *make_tbb_executor(2), 16), first);
    EXPECT_EQ(run(GetParam(), "seven", *make_thread_executor(7), 11), first);
}

TEST_P(ShippedGraph, GivesTheSameBytesInShards) {
    const fs::path out = fs::path(testing::TempDir()) / "weft-graphs" / GetParam().stem() / "shards";
    LoadOptions load;
    load.for_run = true;
    load.overrides = small(GetParam(), out);
    const Loaded loaded = load_graph(GetParam().string(), Registry::instance(), load);
    ASSERT_TRUE(loaded.ok());
    try {
        divided_tasks(make_plan(loaded.graph), {});
    } catch (const UsageError& error) {
        GTEST_SKIP() << error.what();
    }
    const auto whole = run(GetParam(), "whole", *make_tbb_executor(2), 32);
    EXPECT_EQ(run_in_shards(loaded.graph, out, 2, *make_tbb_executor(2), 13), whole);
    EXPECT_EQ(run_in_shards(loaded.graph, out, 5, *make_tbb_executor(1), 32), whole);
}

INSTANTIATE_TEST_SUITE_P(All, ShippedGraph, testing::ValuesIn(shipped_graphs()), [](const auto& graph) {
    std::string name = graph.param.stem().string();
    std::replace_if(name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
    return name;
});

}  // namespace
}  // namespace weft
