// Plans: what is needed, in which order, with how many bytes.
#include "runtime/plan.h"

#include <gtest/gtest.h>

#include "tests/runtime/toy_nodes.h"

namespace weft {
namespace {

TEST(Plan, KeepsOnlyWhatAWritingNodeNeeds) {
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "used": {"type": "toy-number"}, "idle": {"type": "toy-number"},
        "note": {"type": "toy-note", "in": {"number": "used"}}}})");
    const Plan plan = make_plan(graph);
    ASSERT_EQ(plan.tasks.size(), 2u);
    EXPECT_EQ(plan.tasks[0].name, "used");
    EXPECT_EQ(plan.instances[size_t(graph.find("idle"))], nullptr);
}

TEST(Plan, PutsAConnectedRunOfStreamNodesInOneSegment) {
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "number": {"type": "toy-number"},
        "dots": {"type": "toy-dots", "in": {"number": "number"}},
        "scale": {"type": "toy-scale", "in": {"dots": "dots"}},
        "sum": {"type": "toy-sum", "in": {"dots": "scale"}},
        "note": {"type": "toy-note", "in": {"grid": "sum.grid"}}}})");
    const Plan plan = make_plan(graph);
    ASSERT_EQ(plan.tasks.size(), 3u);
    EXPECT_TRUE(plan.tasks[1].segment);
    EXPECT_EQ(plan.tasks[1].name, "dots ... sum");
    EXPECT_EQ(plan.tasks[1].needs, std::vector<size_t>{0});
    EXPECT_EQ(plan.tasks[2].needs, std::vector<size_t>{1});
}

TEST(Plan, EstimatesThePeakAndRefusesWhatDoesNotFit) {
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "a": {"type": "toy-number"}, "b": {"type": "toy-number"},
        "sum": {"type": "toy-add", "in": {"numbers": ["a", "b"]}},
        "note": {"type": "toy-note", "in": {"number": "sum"}}}})");
    const Plan plan = make_plan(graph);
    EXPECT_EQ(plan.peak_bytes, 5000);  // while 'sum' runs: two numbers of 1000 and its own 3000
    EXPECT_EQ(plan.tasks[plan.peak_task].name, "sum");

    PlanOptions options;
    options.memory_limit = 4999;
    try {
        make_plan(graph, options);
        FAIL() << "the plan was accepted";
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_NE(message.find("needs 5 kB while 'sum' runs"), std::string::npos) << message;
        EXPECT_NE(message.find("allows 5 kB"), std::string::npos) << message;
    }
    options.memory_limit = 5000;
    EXPECT_NO_THROW(make_plan(graph, options));
}

TEST(Plan, AmountsOfMemoryAreRead) {
    EXPECT_EQ(parse_bytes("8G"), 8e9);
    EXPECT_EQ(parse_bytes("1.5GB"), 1.5e9);
    EXPECT_EQ(parse_bytes("512M"), 512e6);
    EXPECT_EQ(parse_bytes("1000000"), 1e6);
    for (const char* wrong : {"", "G", "8X", "-1G", "0", "8 apples"}) EXPECT_THROW(parse_bytes(wrong), UsageError) << wrong;
}

TEST(Plan, IsPrintedForPeopleAndPrograms) {
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "dots": {"type": "toy-dots"}, "sum": {"type": "toy-sum", "in": {"dots": "dots"}},
        "note": {"type": "toy-note", "in": {"grid": "sum.grid"}}}})");
    const Plan plan = make_plan(graph);
    const std::string text = to_text(plan);
    EXPECT_NE(text.find("segment dots ... sum"), std::string::npos) << text;
    EXPECT_NE(text.find("frees    sum.grid"), std::string::npos) << text;
    const Json json = to_json(plan);
    EXPECT_EQ(json.find("tasks")->items.size(), 2u);
}

}  // namespace
}  // namespace weft
