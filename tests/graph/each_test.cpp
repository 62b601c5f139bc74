// A node that stands several times, once for each value of a list.
#include <gtest/gtest.h>

#include "graph_of.h"

namespace weft {
namespace {

using test::graph_of;
using test::names;
using test::param;
using test::sources;

const char* const several = R"({
  "weft": 1,
  "parameters": {"passes": {"type": "list", "default": [3, 1, 2]}},
  "nodes": {
    "samples": {"type": "read-samples", "set": {"file": "a.npz"}},
    "first":   {"type": "pixel-filter", "in": {"samples": "samples"}},
    "guide":   {"type": "pixel-filter", "in": {"samples": "samples"}},
    "smooth":  {"type": "bilateral-filter", "each": {"passes": "$passes"}, "carry": {"color": "color"},
                "in": {"color": "first", "guide": "guide"}, "set": {"sigma-range": 0.5, "tint": [1, 1, 1]}},
    "write":   {"type": "write-image", "in": {"image": "smooth"}, "set": {"file": "out.exr"}}
  }
})";

TEST(each, makes_a_node_for_each_value) {
    const Graph graph = graph_of(several);
    EXPECT_EQ(names(graph), "samples first guide smooth-1 smooth-2 smooth-3 write");
    EXPECT_EQ(param(graph, "smooth-1", "passes"), Json(3));
    EXPECT_EQ(param(graph, "smooth-2", "passes"), Json(1));
    EXPECT_EQ(param(graph, "smooth-3", "passes"), Json(2));
    EXPECT_EQ(param(graph, "smooth-3", "sigma-range"), Json(0.5));
}

TEST(each, carries_outputs_from_one_to_the_next) {
    const Graph graph = graph_of(several);
    EXPECT_EQ(sources(graph, "smooth-1", "color"), "first.color");
    EXPECT_EQ(sources(graph, "smooth-2", "color"), "smooth-1.color");
    EXPECT_EQ(sources(graph, "smooth-3", "color"), "smooth-2.color");
    for (const char* one : {"smooth-1", "smooth-2", "smooth-3"})
        EXPECT_EQ(sources(graph, one, "guide"), "guide.color");
    EXPECT_EQ(sources(graph, "write", "image"), "smooth-3.color");
}

TEST(each, takes_its_list_and_single_nodes_from_options) {
    LoadOptions options;
    options.overrides.set = {"passes=[4, 5]", "smooth-2.sigma-range=0.25"};
    const Graph graph = graph_of(several, options);
    EXPECT_EQ(names(graph), "samples first guide smooth-1 smooth-2 write");
    EXPECT_EQ(param(graph, "smooth-2", "passes"), Json(5));
    EXPECT_EQ(param(graph, "smooth-1", "sigma-range"), Json(0.5));
    EXPECT_EQ(param(graph, "smooth-2", "sigma-range"), Json(0.25));
}

// Text keeps its dollars; graphs stand several times as single nodes do.
TEST(each, repeats_graphs_and_keeps_texts) {
    const test::Folder folder;
    folder.write("parts/sheet.json", R"({"weft": 1,
      "parameters": {"title": {"type": "text", "default": ""}},
      "inputs": {"color": {"type": "Image"}}, "outputs": {"image": "sheet"},
      "nodes": {"sheet": {"type": "contact-sheet", "in": {"pictures": ["color"]}, "set": {"title": "$title"}}}})");
    const Graph graph = graph_of(R"({"weft": 1, "nodes": {
        "samples": {"type": "read-samples", "set": {"file": "a.npz"}},
        "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}},
        "part":    {"type": "parts/sheet.json", "each": {"title": ["5$$", "b"]}, "carry": {"color": "image"}, "in": {"color": "filter"}},
        "write":   {"type": "write-image", "in": {"image": "part"}, "set": {"file": "out.exr"}}}})",
                                 {}, folder / "graph.json");
    EXPECT_EQ(param(graph, "part-1/sheet", "title"), Json("5$"));
    EXPECT_EQ(param(graph, "part-2/sheet", "title"), Json("b"));
    EXPECT_EQ(sources(graph, "part-2/sheet", "pictures"), "part-1/sheet.image");
}

}  // namespace
}  // namespace weft
