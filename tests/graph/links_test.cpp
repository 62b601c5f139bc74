// Links: a node and its port, or a node alone; through graphs used as nodes; past bypassed nodes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "graph_of.h"

namespace weft {
namespace {

using test::Folder;
using test::graph_of;
using test::load;
using test::names;
using test::sources;

// A document whose nodes follow a reader and a filter "picture".
std::string with(const std::string& nodes, const std::string& more = "") {
    return R"({"weft": 1, )" + more + R"("nodes": {
      "samples": {"type": "read-samples", "set": {"file": "a.npz"}},
      "picture": {"type": "pixel-filter", "in": {"samples": "samples"}},
      )" + nodes +
           "}}";
}

const char* const smooth = R"({
  "weft": 1,
  "parameters": {"range": {"type": "number", "default": 0.5}},
  "inputs": {"color": {"type": "Image"}, "guide": {"type": "Image", "optional": true}},
  "outputs": {"color": "second.color", "first": "first"},
  "nodes": {
    "first":  {"type": "bilateral-filter", "in": {"color": "color", "guide": "guide"}, "set": {"sigma-range": "$range"}},
    "second": {"type": "bilateral-filter", "in": {"color": "first"}}
  }
})";

TEST(links, a_node_alone_means_its_only_output_or_the_one_that_fits) {
    const Graph graph = graph_of(with(R"(
      "split": {"type": "split-image", "in": {"color": "picture"}},
      "table": {"type": "write-table", "in": {"table": "split"}, "set": {"rows": 1}},
      "write": {"type": "write-image", "in": {"image": "split.high"}, "set": {"file": "a.exr"}})"));
    EXPECT_EQ(sources(graph, "table", "table"), "split.error");
    EXPECT_EQ(sources(graph, "write", "image"), "split.high");
    EXPECT_EQ(sources(graph, "split", "color"), "picture.color");
}

TEST(links, a_variadic_input_takes_one_or_a_list_in_its_order) {
    const Graph graph = graph_of(with(R"(
      "split": {"type": "split-image", "in": {"color": "picture"}},
      "list":  {"type": "contact-sheet", "in": {"pictures": ["split.high", "picture", "split.low", "picture"]}},
      "one":   {"type": "contact-sheet", "in": {"pictures": "list"}},
      "write": {"type": "write-image", "in": {"image": "one"}, "set": {"file": "a.exr"}})"));
    EXPECT_EQ(sources(graph, "list", "pictures"),
              "split.high picture.color split.low picture.color");
    EXPECT_EQ(sources(graph, "one", "pictures"), "list.image");
}

TEST(links, names_of_flattened_documents_are_names) {
    const Graph graph = graph_of(with(R"(
      "pass-1/inner_2": {"type": "median-filter", "in": {"color": "picture"}},
      "write": {"type": "write-image", "in": {"image": "pass-1/inner_2.picture"}, "set": {"file": "a.exr"}})"));
    EXPECT_EQ(sources(graph, "write", "image"), "pass-1/inner_2.picture");
}

TEST(links, a_graph_as_a_node_is_flattened_under_its_name) {
    Folder folder;
    folder.write("parts/smooth.json", smooth);
    const Graph graph = graph_of(with(R"(
      "pass":  {"type": "parts/smooth.json", "in": {"color": "picture"}, "set": {"range": 3}},
      "again": {"type": "parts/smooth.json", "in": {"color": "pass.color", "guide": "pass.first"}},
      "write": {"type": "write-image", "in": {"image": "again.color"}, "set": {"file": "a.exr"}})"),
                                 {}, folder / "top.json");
    EXPECT_EQ(names(graph),
              "samples picture pass/first pass/second again/first again/second write");
    EXPECT_EQ(sources(graph, "pass/first", "color"), "picture.color");
    EXPECT_EQ(sources(graph, "pass/first", "guide"), "");
    EXPECT_EQ(sources(graph, "again/first", "color"), "pass/second.color");
    EXPECT_EQ(sources(graph, "again/first", "guide"), "pass/first.color");
    EXPECT_EQ(sources(graph, "write", "image"), "again/second.color");
    EXPECT_EQ(test::param(graph, "pass/first", "sigma-range"), Json(3));
    EXPECT_EQ(test::param(graph, "again/first", "sigma-range"), Json(0.5));
}

TEST(links, graphs_nest_and_find_their_parts_beside_themselves) {
    Folder folder;
    folder.write("parts/deep/smooth.json", smooth);
    folder.write("parts/twice.json", R"({
      "weft": 1,
      "parameters": {"range": {"type": "integer", "default": 7}},
      "inputs": {"picture": {"type": "Image"}},
      "outputs": {"picture": "b.color", "same": "picture"},
      "nodes": {
        "a": {"type": "deep/smooth.json", "in": {"color": "picture"}, "set": {"range": "$range"}},
        "b": {"type": "deep/smooth.json", "in": {"color": "a.color", "guide": "picture"}}
      }
    })");
    const Graph graph = graph_of(with(R"(
      "outer": {"type": "parts/twice.json", "in": {"picture": "picture"}},
      "sheet": {"type": "contact-sheet", "in": {"pictures": ["outer.picture", "outer.same"]}},
      "write": {"type": "write-image", "in": {"image": "sheet"}, "set": {"file": "a.exr"}})"),
                                 {}, folder / "top.json");
    EXPECT_EQ(sources(graph, "outer/b/first", "guide"), "picture.color");
    EXPECT_EQ(sources(graph, "sheet", "pictures"), "outer/b/second.color picture.color");
    EXPECT_EQ(test::param(graph, "outer/a/first", "sigma-range"), Json(7));
}

TEST(links, a_bypassed_node_passes_its_first_input_on) {
    const Graph graph = graph_of(with(R"(
      "a":     {"type": "bilateral-filter", "in": {"color": "picture"}, "bypass": true},
      "b":     {"type": "median-filter", "in": {"color": "a"}, "bypass": true},
      "c":     {"type": "median-filter", "in": {"color": "b.picture"}, "bypass": false},
      "write": {"type": "write-image", "in": {"image": "c"}, "set": {"file": "a.exr"}})"));
    EXPECT_EQ(names(graph), "samples picture c write");
    EXPECT_EQ(sources(graph, "c", "color"), "picture.color");
}

TEST(links, a_bypassed_graph_vanishes_whole) {
    Folder folder;
    folder.write("smooth.json", smooth);
    const Graph graph = graph_of(with(R"(
      "pass":  {"type": "smooth.json", "in": {"color": "picture"}, "bypass": true},
      "write": {"type": "write-image", "in": {"image": "pass.color"}, "set": {"file": "a.exr"}})"),
                                 {}, folder / "top.json");
    EXPECT_EQ(names(graph), "samples picture write");
    EXPECT_EQ(sources(graph, "write", "image"), "picture.color");
}

TEST(links, outputs_of_a_document_lead_to_its_nodes) {
    const Graph graph =
        graph_of(with(R"("m": {"type": "median-filter", "in": {"color": "picture"}})",
                      R"("outputs": {"result": "m", "raw": "picture.color"}, )"));
    ASSERT_EQ(graph.outputs.size(), 2u);
    EXPECT_EQ(graph.nodes[size_t(graph.outputs.at("result").node)].name, "m");
    EXPECT_EQ(graph.nodes[size_t(graph.outputs.at("raw").node)].name, "picture");
}

TEST(links, a_part_is_checked_alone_but_not_run_alone) {
    EXPECT_EQ(test::all_text(load(smooth).findings), "");
    LoadOptions run;
    run.for_run = true;
    EXPECT_EQ(test::short_text(load(smooth, run).findings),
              "test.json:4:14: input 'color' is not connected: this graph is a part of others, run "
              "one that uses it\n");
}

TEST(links, a_file_that_is_not_there_is_told_by_its_name) {
    Folder folder;
    const Loaded loaded = load_graph(folder / "none.json", test::catalog());
    EXPECT_EQ(test::all_text(loaded.findings),
              (folder / "none.json") + ": error: cannot read the graph: there is no such file\n");
    EXPECT_FALSE(loaded.ok());
    EXPECT_FALSE(load_graph(folder / "", test::catalog()).ok());
}

// Two copies of the level below at each level: thirty files, a thousand million nodes.
TEST(links, a_graph_that_grows_without_end_is_refused) {
    Folder folder;
    folder.write("p0.json",
                 R"({"weft": 1, "inputs": {"c": {"type": "Image"}}, "outputs": {"c": "m"},
      "nodes": {"m": {"type": "median-filter", "in": {"color": "c"}}}})");
    for (int i = 1; i <= 30; ++i)
        folder.write(fmt::format("p{}.json", i), fmt::format(R"({{"weft": 1,
          "inputs": {{"c": {{"type": "Image"}}}}, "outputs": {{"c": "b.c"}}, "nodes": {{
            "a": {{"type": "p{0}.json", "in": {{"c": "c"}}}}, "b": {{"type": "p{0}.json", "in": {{"c": "a"}}}}}}}})",
                                                             i - 1));
    const Loaded loaded = load_graph(folder / "p30.json", test::catalog());
    EXPECT_FALSE(loaded.ok());
    EXPECT_NE(test::all_text(loaded.findings).find("the graph has more than"), std::string::npos);
}

}  // namespace
}  // namespace weft
