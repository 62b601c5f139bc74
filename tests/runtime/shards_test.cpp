// Shards and their merge: the single run's result, however the work was divided.
#include "runtime/shard.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "runtime/atomic_file.h"
#include "runtime/run.h"
#include "tests/runtime/toy_nodes.h"

namespace weft {
namespace {

const char* const stream_graph = R"({"weft": 1, "nodes": {
    "number": {"type": "toy-number", "set": {"value": 0.5}},
    "dots": {"type": "toy-dots", "in": {"number": "number"}},
    "odd": {"type": "toy-odd", "in": {"dots": "dots"}},
    "more": {"type": "toy-scale", "in": {"dots": "odd.odd"}, "set": {"by": 10}},
    "merge": {"type": "toy-merge", "in": {"dots": "odd.dots", "branch": "more"}},
    "sum": {"type": "toy-sum", "in": {"dots": "merge"}},
    "plain": {"type": "toy-sum", "in": {"dots": "dots"}},
    "again": {"type": "toy-add", "in": {"numbers": ["number", "sum.total"]}},
    "note": {"type": "toy-note", "in": {"grid": "sum.grid", "number": "again"}, "set": {"label": "merged"}},
    "note-2": {"type": "toy-note", "in": {"grid": "plain.grid"}, "set": {"label": "plain"}}}})";

// Two divided nodes, and one that must be run whole before them.
const char* const rows_graph = R"({"weft": 1, "nodes": {
    "number": {"type": "toy-number", "set": {"value": 4}},
    "rows": {"type": "toy-rows", "in": {"number": "number"}},
    "wide": {"type": "toy-rows", "set": {"width": 100, "height": 3}},
    "note": {"type": "toy-note", "in": {"grid": "rows"}, "set": {"label": "rows"}},
    "note-2": {"type": "toy-note", "in": {"grid": "wide"}, "set": {"label": "wide"}}}})";

class Shards : public testing::Test {
  protected:
    Shards() : folder_(std::filesystem::path(testing::TempDir()) / "weft-shards") {
        std::filesystem::create_directories(folder_);
    }
    ~Shards() override { std::filesystem::remove_all(folder_); }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }

    RunResult shard(const Graph& graph, const Shard& of, const std::string& file, int tile,
                    int threads, const std::vector<std::string>& divide = {}) {
        PlanOptions options;
        options.work = Work::shard;
        options.divide = divide;
        const Plan plan = make_plan(graph, options);
        PartHeader header = shard_header(plan, files_read(plan), of, tile);
        PartWriter part(file);
        RunOptions run;
        run.tile = tile;
        run.shard = of;
        run.part = &part;
        Monitor monitor;
        RunResult result = run_plan(plan, *make_thread_executor(threads), monitor, run);
        if (!result.ok()) return result;
        header.tasks = result.divided;
        part.finish(header);
        return result;
    }
    std::vector<std::string> shards(const Graph& graph, int count, int tile = 32, int threads = 2,
                                    const std::vector<std::string>& divide = {}) {
        std::vector<std::string> files;
        for (int i = 1; i <= count; ++i) {
            files.insert(files.begin(), path(std::to_string(i) + ".part"));  // the last comes first
            EXPECT_TRUE(shard(graph, {i, count}, files.front(), tile, threads, divide).ok());
        }
        return files;
    }
    RunResult merge(const std::vector<std::string>& files, int threads = 2) {
        const Parts parts(files);
        const Graph graph = toy_graph(parts.header().provenance.graph);
        const Plan plan = make_plan(graph, merge_options(parts.header()));
        RunOptions run;
        run.tile = parts.header().tile;
        run.parts = &parts;
        Notes::instance().clear();
        Monitor monitor;
        return run_plan(plan, *make_thread_executor(threads), monitor, run);
    }
    std::string merge_error(const std::vector<std::string>& files) {
        try {
            merge(files);
        } catch (const Error& error) {
            return error.what();
        }
        ADD_FAILURE() << "the merge went through";
        return "";
    }

  private:
    std::filesystem::path folder_;
};

TEST_F(Shards, OfASegmentGiveTheSingleRunsBits) {
    const Graph graph = toy_graph(stream_graph);
    ASSERT_TRUE(run_toy(graph, *make_serial_executor()).ok());
    const std::vector<double> merged = Notes::instance().grid("merged").cells,
                              plain = Notes::instance().grid("plain").cells;
    const auto numbers = Notes::instance().numbers;
    for (const int count : {1, 2, 5, 40})
        for (const int tile : {7, 32, 1000})
            for (const int threads : {1, 4}) {
                ASSERT_TRUE(merge(shards(graph, count, tile, threads), 5 - threads).ok());
                EXPECT_EQ(Notes::instance().grid("merged").cells, merged)
                    << count << " shards, tile " << tile;
                EXPECT_EQ(Notes::instance().grid("plain").cells, plain)
                    << count << " shards, tile " << tile;
                EXPECT_EQ(Notes::instance().numbers, numbers);
            }
}

TEST_F(Shards, OfValueNodesGiveTheSingleRunsBits) {
    const Graph graph = toy_graph(rows_graph);
    ASSERT_TRUE(run_toy(graph, *make_serial_executor()).ok());
    const std::vector<double> rows = Notes::instance().grid("rows").cells,
                              wide = Notes::instance().grid("wide").cells;
    for (const int count : {1, 2, 5, 30}) {
        ASSERT_TRUE(merge(shards(graph, count)).ok());
        EXPECT_EQ(Notes::instance().grid("rows").cells, rows);
        EXPECT_EQ(Notes::instance().grid("wide").cells, wide);
    }
}

TEST_F(Shards, DoTheirOwnTilesOnlyAndNothingAfterThem) {
    const Graph graph = toy_graph(stream_graph);  // 100 x 70: 12 tiles of 32
    Notes::instance().clear();
    const RunResult result = shard(graph, {2, 5}, path("2.part"), 32, 2);
    ASSERT_TRUE(result.ok());
    ASSERT_EQ(result.segments.size(), 1u);
    EXPECT_EQ(result.segments[0].tiles, 3u);  // 1, 6, 11
    EXPECT_FALSE(Notes::instance().has("merged"));
    ASSERT_EQ(result.divided.size(), 1u);
    EXPECT_EQ(result.divided[0].items, 12u);
    EXPECT_EQ(result.divided[0].sinks, (std::vector<std::string>{"sum", "plain"}));
}

TEST_F(Shards, TheMergeRunsNothingBeforeThem) {
    const Graph graph = toy_graph(rows_graph);
    const RunResult result = merge(shards(graph, 2));
    for (const StageReport& node : result.nodes) EXPECT_NE(node.name, "number");
}

TEST_F(Shards, WhatIsDividedCanBeChosen) {
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "rows": {"type": "toy-rows"},
        "number": {"type": "toy-number", "set": {"value": 1}},
        "dots": {"type": "toy-dots", "in": {"number": "number"}},
        "sum": {"type": "toy-sum", "in": {"dots": "dots"}},
        "note": {"type": "toy-note", "in": {"grid": "rows"}, "set": {"label": "rows"}},
        "note-2": {"type": "toy-note", "in": {"grid": "sum.grid"}, "set": {"label": "sum"}}}})");
    PlanOptions options;
    options.work = Work::shard;
    options.divide = {"sum"};
    EXPECT_EQ(make_plan(graph, options).tasks.size(), 2u);  // number, and the segment
    ASSERT_TRUE(run_toy(graph, *make_serial_executor()).ok());
    const std::vector<double> rows = Notes::instance().grid("rows").cells,
                              sum = Notes::instance().grid("sum").cells;
    for (const char* divide : {"sum", "dots", "rows"}) {
        ASSERT_TRUE(merge(shards(graph, 3, 32, 2, {divide})).ok());
        EXPECT_EQ(Notes::instance().grid("rows").cells, rows);
        EXPECT_EQ(Notes::instance().grid("sum").cells, sum);
    }
}

std::string division_error(const char* graph_text, const std::vector<std::string>& divide = {}) {
    const Graph graph = toy_graph(graph_text);
    PlanOptions options;
    options.work = Work::shard;
    options.divide = divide;
    try {
        make_plan(graph, options);
    } catch (const UsageError& error) {
        return error.what();
    }
    ADD_FAILURE() << "it was divided";
    return "";
}

TEST(Division, WhatCannotBeDividedIsSaid) {
    const char* const numbers =
        R"({"weft": 1, "nodes": {"a": {"type": "toy-number"}, "note": {"type": "toy-note", "in": {"number": "a"}}}})";
    EXPECT_NE(division_error(numbers).find("run it whole, without --shard"), std::string::npos);
    EXPECT_NE(division_error(numbers, {"a"}).find("'a' cannot be divided"), std::string::npos);
    EXPECT_NE(division_error(numbers, {"nota"}).find("did you mean 'note'?"), std::string::npos);
    EXPECT_NE(
        division_error(R"({"weft": 1, "nodes": {"a": {"type": "toy-rows", "set": {"whole": true}},
        "note": {"type": "toy-note", "in": {"grid": "a"}}}})")
            .find("nothing in this graph"),
        std::string::npos);
    EXPECT_NE(
        division_error(
            R"({"weft": 1, "nodes": {"dots": {"type": "toy-dots"}, "drain": {"type": "toy-drain", "in": {"dots": "dots"}},
        "note": {"type": "toy-note", "in": {"number": "drain"}}}})")
            .find("'drain' (toy-drain) cannot hand out its tiles"),
        std::string::npos);
}

TEST_F(Shards, APartThatIsMissingDoubleOrForeignIsNamed) {
    const Graph graph = toy_graph(stream_graph);
    const std::vector<std::string> all = shards(graph, 3);
    EXPECT_NE(merge_error({all[0], all[2]}).find("shard 2/3"), std::string::npos);
    EXPECT_NE(merge_error({all[0], all[1], all[1], all[2]}).find("2.part are both shard 2/3"),
              std::string::npos);

    const std::string other = path("other.part");
    const auto foreign = [&] { return merge_error({all[0], other, all[2]}); };
    ASSERT_TRUE(shard(toy_graph(stream_graph, {.set = {"more.by=11"}, .swap = {}, .bypass = {}}),
                      {2, 3}, other, 32, 1)
                    .ok());
    EXPECT_NE(foreign().find("other.part: is not of the same run"), std::string::npos);
    ASSERT_TRUE(shard(graph, {2, 3}, other, 16, 1).ok());
    EXPECT_NE(foreign().find("make it again with --tile 32"), std::string::npos);
    ASSERT_TRUE(shard(graph, {2, 4}, other, 32, 1).ok());
    EXPECT_NE(foreign().find("shard 2/4, the other 3/3"), std::string::npos);
    ASSERT_TRUE(shard(graph, {2, 3}, other, 32, 1).ok());
    EXPECT_TRUE(merge({all[0], other, all[2]}).ok());
}

TEST_F(Shards, AFailedShardLeavesNoPart) {
    const Graph graph =
        toy_graph(stream_graph, {.set = {"more.fail-at-pixel=101"}, .swap = {}, .bypass = {}});
    const RunResult result = shard(graph, {1, 1}, path("1.part"), 32, 2);
    ASSERT_EQ(result.errors.size(), 1u);
    EXPECT_EQ(result.errors[0].node, "more");
    EXPECT_FALSE(std::filesystem::exists(path("1.part")));
}

TEST_F(Shards, AFileThatTheMergeReadsTooMustBeTheSame) {
    write_file(path("number"), "5");
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "number": {"type": "toy-read", "set": {"file": ")" +
                                  path("number") + R"("}},
        "rows": {"type": "toy-rows", "in": {"number": "number"}},
        "note": {"type": "toy-note", "in": {"grid": "rows", "number": "number"}, "set": {"label": "rows"}}}})");
    const Parts parts(shards(graph, 2));
    const Graph again = toy_graph(parts.header().provenance.graph);
    const Plan plan = make_plan(again, merge_options(parts.header()));
    EXPECT_NO_THROW(expect_same_files(plan, parts.header()));
    write_file(path("number"), "6");
    EXPECT_THROW(expect_same_files(plan, parts.header()), Error);
}

TEST(Shard, IsReadFromText) {
    EXPECT_EQ(parse_shard("2/5"), (Shard{2, 5}));
    for (const char* wrong :
         {"", "2", "0/5", "6/5", "2/", "/5", "2/5x", "-1/5", "2/99999999999", "a/b"})
        EXPECT_THROW(parse_shard(wrong), UsageError) << wrong;
}

}  // namespace
}  // namespace weft
