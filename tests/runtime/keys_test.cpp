// Keys: what changes one, and what must not.
#include "runtime/keys.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "runtime/isa.h"
#include "tests/runtime/toy_nodes.h"

namespace weft {
namespace {

const std::string graph_text = R"({"weft": 1, "about": "numbers", "nodes": {
    "a": {"type": "toy-number", "set": {"value": 2}},
    "b": {"type": "toy-number", "set": {"value": 3}},
    "sum": {"type": "toy-add", "in": {"numbers": ["a", "b"]}},
    "dots": {"type": "toy-dots", "in": {"number": "a"}},
    "scaled": {"type": "toy-scale", "in": {"dots": "dots"}},
    "grid": {"type": "toy-sum", "in": {"dots": "scaled"}},
    "note": {"type": "toy-note", "in": {"grid": "grid.grid", "number": "sum"}}}})";

std::string with(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

struct Made {
    Graph graph;
    Keys keys;
    Key of(const std::string& node, int port = 0) const {
        return keys.of({graph.find(node), port});
    }
};

Made keys_of(const std::string& text, const Overrides& overrides = {}) {
    Made made;
    made.graph = toy_graph(text, overrides);
    const Plan plan = make_plan(made.graph);
    made.keys = make_keys(plan, files_read(plan));
    return made;
}

TEST(Keys, AreTheSameForTheSameGraph) {
    const Made one = keys_of(graph_text), two = keys_of(graph_text);
    EXPECT_EQ(one.keys.outputs, two.keys.outputs);
    EXPECT_EQ(one.keys.run, two.keys.run);
    EXPECT_EQ(one.of("sum").text().size(), 32u);
}

TEST(Keys, DifferFromOutputToOutputAndNodeToNode) {
    const Made made = keys_of(graph_text);
    std::set<Key> seen;
    size_t outputs = 0;
    for (const auto& node : made.keys.outputs)
        for (const Key& key : node) {
            seen.insert(key);
            ++outputs;
        }
    EXPECT_EQ(seen.size(), outputs);
}

TEST(Keys, AParameterChangesItsNodeAndAllAfterIt) {
    const Made one = keys_of(graph_text),
               two = keys_of(graph_text, {.set = {"scaled.by=3"}, .swap = {}, .bypass = {}});
    for (const char* same : {"a", "b", "sum", "dots"})
        EXPECT_EQ(one.of(same), two.of(same)) << same;
    for (const char* other : {"scaled", "grid"}) EXPECT_NE(one.of(other), two.of(other)) << other;
    EXPECT_NE(one.keys.run, two.keys.run);
}

TEST(Keys, TheSameNumberWrittenOtherwiseIsTheSame) {
    EXPECT_EQ(keys_of(graph_text).of("a"),
              keys_of(with(graph_text, "\"value\": 2", "\"value\": 2.0")).of("a"));
    EXPECT_EQ(keys_of(graph_text).of("scaled"),
              keys_of(with(graph_text, "{\"dots\": \"dots\"}}",
                           "{\"dots\": \"dots\"}, \"set\": {\"by\": 2}}"))
                  .of("scaled"));
}

TEST(Keys, NamesAboutLayoutAndOrderOfNodesDoNotEnter) {
    const Made one = keys_of(graph_text);
    std::string text = with(graph_text, "\"about\": \"numbers\"",
                            "\"about\": \"else\", \"layout\": {\"a\": [1, 2]}");
    text = with(with(text, "\"dots\": {\"type\"", "\"points\": {\"type\""), "{\"dots\": \"dots\"}",
                "{\"dots\": \"points\"}");
    EXPECT_EQ(one.of("grid"), keys_of(text).of("grid"));
    EXPECT_EQ(one.keys.run, keys_of(text).keys.run);
    const std::string swapped =
        with(with(graph_text, "\"b\": {\"type\": \"toy-number\", \"set\": {\"value\": 3}},", ""),
             "\"note\":", "\"b\": {\"type\": \"toy-number\", \"set\": {\"value\": 3}}, \"note\":");
    EXPECT_EQ(one.keys.run, keys_of(swapped).keys.run);
}

TEST(Keys, OrderAndNamesOfManyLinksToOneInputEnter) {
    const Key sum = keys_of(graph_text).of("sum");
    EXPECT_NE(sum, keys_of(with(graph_text, "[\"a\", \"b\"]", "[\"b\", \"a\"]")).of("sum"));
    EXPECT_NE(sum, keys_of(with(graph_text, "[\"a\", \"b\"]", "[\"a\", \"a\"]")).of("sum"));
    EXPECT_NE(sum, keys_of(with(with(graph_text, "\"b\": {", "\"c\": {"), "[\"a\", \"b\"]",
                                "[\"a\", \"c\"]"))
                       .of("sum"));
}

TEST(Keys, AnotherTypeInPlaceOfANodeEnters) {
    EXPECT_NE(keys_of(graph_text).of("scaled"),
              keys_of(graph_text, {.set = {}, .swap = {"scaled=toy-batch-hook"}, .bypass = {}})
                  .of("scaled"));
}

class KeysOfFiles : public testing::Test {
  protected:
    KeysOfFiles() : folder(std::filesystem::path(testing::TempDir()) / "weft-keys") {
        std::filesystem::create_directories(folder);
    }
    ~KeysOfFiles() override { std::filesystem::remove_all(folder); }
    std::string file(const std::string& name, const std::string& text) {
        std::ofstream(folder / name) << text;
        return (folder / name).string();
    }
    Made keys(const std::string& in, const std::string& beside = "",
              const std::string& out = "a.txt") {
        return keys_of(
            R"({"weft": 1, "parameters": {"out": {"type": "file", "default": "b.txt"}}, "nodes": {
            "read": {"type": "toy-read", "set": {"file": ")" +
                in + R"(", "beside": ")" + beside + R"("}},
            "write": {"type": "toy-write", "in": {"number": "read"}, "set": {"file": "$out"}}}})",
            {.set = {"out=" + out}, .swap = {}, .bypass = {}});
    }
    std::filesystem::path folder;
};

TEST_F(KeysOfFiles, ContentOfAFileReadEntersAndItsPathDoesNot) {
    const Key one = keys(file("one", "12")).of("read");
    EXPECT_EQ(one, keys(file("two", "12")).of("read"));
    EXPECT_NE(one, keys(file("three", "13")).of("read"));
    EXPECT_NE(one, keys(file("one", "14")).of("read"));
}

TEST_F(KeysOfFiles, ANameThatIsNoFileEntersAsItIs) {
    EXPECT_NE(keys("builtin:x").of("read"), keys("builtin:y").of("read"));
}

TEST_F(KeysOfFiles, FurtherFilesThatANodeReadsEnter) {
    const std::string one = file("one", "12"), beside = file("beside", "1");
    const Key key = keys(one, beside).of("read");
    file("beside", "2");
    EXPECT_NE(key, keys(one, beside).of("read"));
    file("beside", "1");
    EXPECT_EQ(key, keys(one, beside).of("read"));
}

TEST_F(KeysOfFiles, NamesOfFilesWrittenDoNotEnter) {
    const std::string one = file("one", "12");
    EXPECT_EQ(keys(one, "", "x.txt").keys.run, keys(one, "", "y/z.txt").keys.run);
}

TEST(Keys, TheInstructionSetEnters) {
    const Isa before = active_isa();
    const Key best = keys_of(graph_text).of("a");
    pin_isa(Isa::v2);
    const Key least = keys_of(graph_text).of("a");
    pin_isa(before);
    if (before == Isa::v2) GTEST_SKIP() << "this processor has only one";
    EXPECT_NE(best, least);
}

}  // namespace
}  // namespace weft
