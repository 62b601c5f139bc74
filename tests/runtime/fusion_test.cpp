// Fusions: where one stands for the stages it matches, where it does not, and that nothing else
// changes.
#include <gtest/gtest.h>

#include "runtime/keys.h"
#include "tests/runtime/toy_nodes.h"

namespace weft {
namespace {

// dots -> scale -> odd -> more -> merge -> sum; `extra` are further nodes, `scale` further members
// of that node.
Graph graph_with(const std::string& extra = "", const std::string& scale = R"("set": {"by": 3})") {
    return toy_graph(R"({"weft": 1, "nodes": {
        "number": {"type": "toy-number", "set": {"value": 2}},
        "dots": {"type": "toy-dots"},
        "scale": {"type": "toy-scale", "in": {"dots": "dots", "number": "number"}, )" +
                     scale + R"(},
        "odd": {"type": "toy-odd", "in": {"dots": "scale"}},
        "more": {"type": "toy-scale", "in": {"dots": "odd.odd"}, "set": {"by": 10}},
        "merge": {"type": "toy-merge", "in": {"dots": "odd.dots", "branch": "more"}},
        "sum": {"type": "toy-sum", "in": {"dots": "merge"}},)" +
                     extra + R"(
        "note": {"type": "toy-note", "in": {"grid": "sum.grid"}}}})");
}

std::vector<double> run(const Graph& graph, const PlanOptions& options, RunResult& result,
                        int threads = 1) {
    Notes::instance().clear();
    Monitor monitor;
    result = run_plan(make_plan(graph, options), *make_thread_executor(threads), monitor);
    return Notes::instance().has("note") ? Notes::instance().grid("note").cells
                                         : std::vector<double>();
}

bool fuses(const Graph& graph, const PlanOptions& options = {}) {
    return to_text(make_plan(graph, options)).find("fused    scale+odd (toy-scale-odd)") !=
           std::string::npos;
}

PlanOptions unfused() {
    PlanOptions options;
    options.fuse = false;
    return options;
}

TEST(Fusion, GivesWhatItsPartsGive) {
    const Graph graph = graph_with();
    ASSERT_TRUE(fuses(graph));
    RunResult fused, apart;
    const std::vector<double> one = run(graph, {}, fused, 2), other = run(graph, unfused(), apart);
    ASSERT_EQ(one.size(), 7000u);
    EXPECT_EQ(one, other);
    EXPECT_EQ(fused.segments.at(0).stages.at(1).name, "scale+odd");
    EXPECT_EQ(fused.segments.at(0).stages.at(1).type, "toy-scale-odd");
    EXPECT_EQ(fused.segments.at(0).stages.at(1).items.at("dots"),
              apart.segments.at(0).stages.at(2).items.at("dots"));
    EXPECT_EQ(apart.segments.at(0).stages.size(), fused.segments.at(0).stages.size() + 1);
}

TEST(Fusion, IsShownInAPlanAndLeftOutOnDemand) {
    const Graph graph = graph_with();
    EXPECT_FALSE(fuses(graph, unfused()));
    const Json plan = to_json(make_plan(graph));
    bool found = false;
    for (const Json& task : plan.find("tasks")->items)
        for (const Json& fusion : task.find("fused")->items)
            found = found || fusion.find("name")->text == "scale+odd";
    EXPECT_TRUE(found);
}

TEST(Fusion, LeavesAloneWhatIsTapped) {
    const Graph graph = graph_with();
    PlanOptions inside, outside;
    inside.taps = {"scale.dots@1,1=dots.json"};
    outside.taps = {"odd.odd@1,1=odd.json"};
    EXPECT_FALSE(fuses(graph, inside));
    EXPECT_TRUE(fuses(graph, outside));
}

TEST(Fusion, LeavesAloneWhatOthersRead) {
    EXPECT_FALSE(fuses(graph_with(R"(
        "plain": {"type": "toy-sum", "in": {"dots": "scale"}},
        "note-2": {"type": "toy-note", "in": {"grid": "plain.grid"}, "set": {"label": "plain"}},)")));
    // A reader that nothing needs does not count.
    EXPECT_TRUE(fuses(graph_with(R"("plain": {"type": "toy-sum", "in": {"dots": "scale"}},)")));
}

TEST(Fusion, LeavesAloneWhatItSaysItCannotDo) {
    const Graph graph = graph_with("", R"("set": {"by": 7})");
    EXPECT_FALSE(fuses(graph));
    RunResult result;
    EXPECT_EQ(run(graph, {}, result).size(), 7000u);
}

TEST(Fusion, AnErrorIsPlacedAtItsFirstPart) {
    RunResult result;
    run(graph_with("", R"("set": {"by": 3, "fail-at-pixel": 11})"), {}, result);
    ASSERT_EQ(result.errors.size(), 1u);
    EXPECT_EQ(result.errors[0].node, "scale");
    EXPECT_NE(result.errors[0].message.find("cannot scale this one"), std::string::npos);
}

TEST(Fusion, IsPartOfKeys) {
    const Graph graph = graph_with();
    const auto key = [&](const PlanOptions& options) {
        const Plan plan = make_plan(graph, options);
        return make_keys(plan, files_read(plan)).run.text();
    };
    EXPECT_NE(key({}), key(unfused()));
    EXPECT_EQ(key({}), key({}));
}

}  // namespace
}  // namespace weft
