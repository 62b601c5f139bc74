// Running a plan: the same bits however it is run, failures, skips, cancellation, selections, taps.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/runtime/toy_nodes.h"

namespace weft {
namespace {

const char* const stream_graph = R"({"weft": 1, "nodes": {
    "dots": {"type": "toy-dots"},
    "odd": {"type": "toy-odd", "in": {"dots": "dots"}},
    "more": {"type": "toy-scale", "in": {"dots": "odd.odd"}, "set": {"by": 10}},
    "merge": {"type": "toy-merge", "in": {"dots": "odd.dots", "branch": "more"}},
    "sum": {"type": "toy-sum", "in": {"dots": "merge"}},
    "plain": {"type": "toy-sum", "in": {"dots": "dots"}},
    "note": {"type": "toy-note", "in": {"grid": "sum.grid"}, "set": {"label": "merged"}},
    "note-2": {"type": "toy-note", "in": {"grid": "plain.grid"}, "set": {"label": "plain"}}}})";

std::string slurp(const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

std::string temporary(const std::string& name) {
    return (std::filesystem::path(testing::TempDir()) / name).string();
}

std::vector<std::unique_ptr<Executor>> executors() {
    std::vector<std::unique_ptr<Executor>> all;
    all.push_back(make_serial_executor());
    for (int n : {1, 2, 7}) all.push_back(make_thread_executor(n));
#ifndef __SANITIZE_THREAD__
    for (int n : {1, 2, 7}) all.push_back(make_tbb_executor(n));
#endif
    return all;
}

TEST(Run, GivesTheSameBitsForAnyThreadsAndTiles) {
    const Graph graph = toy_graph(stream_graph);
    std::vector<double> first;
    for (const auto& executor : executors())
        for (int tile : {5, 16, 32, 1000}) {
            RunOptions options;
            options.tile = tile;
            const RunResult result = run_toy(graph, *executor, options);
            ASSERT_TRUE(result.ok());
            const Grid& grid = Notes::instance().grid("merged");
            if (first.empty()) first = grid.cells;
            ASSERT_EQ(grid.cells, first) << executor->threads() << " threads, tile " << tile;
        }
}

TEST(Run, ASelectionIsMergedBackInPlace) {
    const Graph graph = toy_graph(stream_graph);
    ASSERT_TRUE(run_toy(graph, *make_serial_executor()).ok());
    const Grid &merged = Notes::instance().grid("merged"), &plain = Notes::instance().grid("plain");
    ASSERT_EQ(merged.cells.size(), 7000u);
    for (size_t i = 0; i < merged.cells.size(); ++i)
        EXPECT_NEAR(merged.cells[i], plain.cells[i] * (i % 2 ? 10 : 1), 1e-4) << "pixel " << i;
}

TEST(Run, CountsWhatEveryStageDid) {
    const Graph graph = toy_graph(stream_graph);
    const RunResult result = run_toy(graph, *make_thread_executor(3));
    ASSERT_EQ(result.segments.size(), 1u);
    std::map<std::string, std::uint64_t> dots;
    for (const StageReport& stage : result.segments[0].stages) dots[stage.name] = stage.items.count("dots") ? stage.items.at("dots") : 0;
    EXPECT_EQ(dots["dots"], 21000u);
    EXPECT_EQ(dots["more"], 10500u);
    EXPECT_EQ(dots["sum"], 21000u);
}

TEST(Run, LoopsMayNest) {
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "a": {"type": "toy-nested"}, "b": {"type": "toy-nested"}, "sum": {"type": "toy-add", "in": {"numbers": ["a", "b"]}},
        "note": {"type": "toy-note", "in": {"number": "sum"}}}})");
    for (const auto& executor : executors()) {
        ASSERT_TRUE(run_toy(graph, *executor).ok());
        EXPECT_EQ(Notes::instance().numbers.at(0).second, 1024);
    }
}

TEST(Run, AFailureIsNamedItsDependentsAreSkippedAndOtherBranchesFinish) {
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "good": {"type": "toy-number"},
        "bad": {"type": "toy-number", "set": {"fail": true}},
        "sum": {"type": "toy-add", "in": {"numbers": ["good", "bad"]}},
        "lost": {"type": "toy-note", "in": {"number": "sum"}, "set": {"label": "lost"}},
        "kept": {"type": "toy-note", "in": {"number": "good"}, "set": {"label": "kept"}}}})");
    for (const auto& executor : executors()) {
        const RunResult result = run_toy(graph, *executor);
        ASSERT_EQ(result.errors.size(), 1u);
        EXPECT_EQ(result.errors[0].node, "bad");
        EXPECT_EQ(result.errors[0].message, "no number today");
        EXPECT_EQ(where(result.errors[0].place).substr(0, 11), "toy.json:3:");
        EXPECT_EQ(result.errors[0].skipped, (std::vector<std::string>{"sum", "lost"}));
        EXPECT_TRUE(Notes::instance().has("kept"));
        EXPECT_FALSE(Notes::instance().has("lost"));
    }
}

TEST(Run, AFailureInAStreamNamesTheStageAndItsInputs) {
    Overrides overrides;
    overrides.set = {"more.fail-at-pixel=333"};
    const RunResult result = run_toy(toy_graph(stream_graph, overrides), *make_thread_executor(2));
    ASSERT_EQ(result.errors.size(), 1u);
    EXPECT_EQ(result.errors[0].node, "more");
    EXPECT_EQ(result.errors[0].message, "cannot scale this one [dots from 'odd' (toy-odd)]");
}

TEST(Run, StopsSoonWhenAsked) {
    std::atomic<bool> stop = false;
    std::atomic<int> batches = 0;
    on_hook = [&] {
        if (++batches == 5) stop = true;
    };
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "dots": {"type": "toy-dots", "set": {"rounds": 100000}}, "hook": {"type": "toy-batch-hook", "in": {"dots": "dots"}},
        "sum": {"type": "toy-sum", "in": {"dots": "hook"}}, "note": {"type": "toy-note", "in": {"grid": "sum.grid"}}}})");
    RunOptions options;
    options.stop = &stop;
    const RunResult result = run_toy(graph, *make_thread_executor(2), options);
    on_hook = nullptr;
    EXPECT_TRUE(result.cancelled);
    EXPECT_TRUE(result.errors.empty());
    EXPECT_LT(batches, 20);
    EXPECT_FALSE(Notes::instance().has("note"));
}

TEST(Run, ValuesAreFreedAfterTheirLastReader) {
    // The plan says when; a long chain must not hold all its values.
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "a": {"type": "toy-number"}, "b": {"type": "toy-hook", "in": {"number": "a"}}, "c": {"type": "toy-hook", "in": {"number": "b"}},
        "note": {"type": "toy-note", "in": {"number": "c"}}}})");
    const Plan plan = make_plan(graph);
    ASSERT_EQ(plan.tasks.size(), 4u);
    for (size_t t = 1; t < 4; ++t) {
        ASSERT_EQ(plan.tasks[t].last_uses.size(), 1u);
        EXPECT_EQ(plan.tasks[t].last_uses[0].node, int(t) - 1);
    }
}

TEST(Run, WhatComesLaterWaitsUntilWhatIsBeforeItIsDoneWith) {
    // Of twelve branches that could all begin at once few hold values at any time.
    std::string nodes;
    for (int k = 10; k < 22; ++k) {
        const std::string n = std::to_string(k);
        nodes += (nodes.empty() ? "" : ", ") + ("\"a" + n) + R"(": {"type": "toy-number"}, "b)" + n + R"(": {"type": "toy-hook", "in": {"number": "a)" + n +
                 R"("}}, "c)" + n + R"(": {"type": "toy-note", "in": {"number": "b)" + n + R"("}})";
    }
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {)" + nodes + "}}");
    for (const auto& executor : executors()) {
        Notes& notes = Notes::instance();
        size_t made = 0, most = 0;
        on_hook = [&] {
            const std::lock_guard lock(notes.mutex);
            ++made;
            most = std::max(most, made - notes.numbers.size());
        };
        EXPECT_TRUE(run_toy(graph, *executor).ok());
        on_hook = nullptr;
        EXPECT_EQ(made, 12u);
        EXPECT_LE(most, 2u) << executor->threads() << " threads";
    }
}

TEST(Taps, AValueIsWrittenAsItsArrays) {
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "a": {"type": "toy-number", "set": {"value": 2.5}}, "note": {"type": "toy-note", "in": {"number": "a"}}}})");
    PlanOptions options;
    options.taps = {"a.number=" + temporary("tap_value.json")};
    const Plan plan = make_plan(graph, options);
    Monitor monitor;
    ASSERT_TRUE(run_plan(plan, *make_serial_executor(), monitor).ok());
    EXPECT_EQ(slurp(temporary("tap_value.json")), "{\"value\": [2.5]}\n");
}

TEST(Taps, AStreamsRecordsOfAPixelDoNotDependOnTiles) {
    const Graph graph = toy_graph(stream_graph);
    std::string first;
    for (int tile : {7, 32, 200}) {
        PlanOptions plan_options;
        plan_options.taps = {"odd.odd@10,20,13,22=" + temporary("tap_stream.json")};
        const Plan plan = make_plan(graph, plan_options);
        Monitor monitor;
        RunOptions options;
        options.tile = tile;
        ASSERT_TRUE(run_plan(plan, *make_thread_executor(2), monitor, options).ok());
        const std::string text = slurp(temporary("tap_stream.json"));
        if (first.empty()) first = text;
        EXPECT_EQ(text, first) << "tile " << tile;
    }
    // Of 3 x 2 pixels, (11, 20) and (11, 21) are odd: two pixels, three rounds each.
    EXPECT_EQ(std::count(first.begin(), first.end(), '\n'), 8) << first;
}

TEST(Taps, WhatIsWrongIsSaid) {
    const Graph graph = toy_graph(stream_graph);
    const auto message = [&](const std::string& tap) -> std::string {
        PlanOptions options;
        options.taps = {tap};
        try {
            make_plan(graph, options);
        } catch (const UsageError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(message("sun.grid=x.json"), "--tap sun.grid=x.json: no node 'sun'; did you mean 'sum'?");
    EXPECT_EQ(message("sum.gird=x.json"), "--tap sum.gird=x.json: 'sum' has no output 'gird'; did you mean 'grid'?");
    EXPECT_NE(message("odd.odd=x.json").find("is a stream; name a pixel"), std::string::npos);
    EXPECT_NE(message("sum.grid@1,2=x.json").find("is written whole"), std::string::npos);
    EXPECT_NE(message("odd.odd@1,b=x.json").find("is no pixel"), std::string::npos);
    EXPECT_NE(message("odd").find("expected node.port=file"), std::string::npos);
}

TEST(Trace, IsJsonWithASpanForEveryNodeAndTile) {
    const Graph graph = toy_graph(stream_graph);
    const Plan plan = make_plan(graph);
    Monitor monitor;
    monitor.tracing = true;
    ASSERT_TRUE(run_plan(plan, *make_thread_executor(2), monitor).ok());
    const Json trace = parse_json_or_throw(monitor.trace(), "trace");
    size_t tiles = 0, nodes = 0;
    for (const Json& event : trace.find("traceEvents")->items) {
        const Json* category = event.find("cat");
        if (!category) continue;
        tiles += category->text == "tile";
        nodes += category->text == "node" || category->text == "segment";
        EXPECT_GE(event.find("dur")->number, 0);
    }
    EXPECT_EQ(tiles, 4u * 3u);
    EXPECT_EQ(nodes, plan.tasks.size());
}

}  // namespace
}  // namespace weft
