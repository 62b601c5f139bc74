// Loading a document: nodes in order, links followed, parameters filled in.
#include <gtest/gtest.h>

#include "graph/graph.h"
#include "graph_of.h"

namespace weft {
namespace {

using test::graph_of;
using test::param;
using test::sources;

const char* const plain = R"({
  "weft": 1,
  "about": "read, filter, write",
  "parameters": {
    "samples": {"type": "file", "default": "analytic:garden"},
    "width":   {"type": "integer", "default": 3, "minimum": 1},
    "out":     {"type": "file", "default": "out/a.exr"}
  },
  "nodes": {
    "write":   {"type": "write-image", "in": {"image": "filter.color"}, "set": {"file": "$out"}},
    "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}, "set": {"width": "$width", "filter": "tent"}},
    "samples": {"type": "read-samples@2", "set": {"file": "$samples"}}
  },
  "layout": {"anything": [1, 2, 3]}
})";

TEST(load, nodes_stand_after_those_they_read_from) {
    const Graph graph = graph_of(plain);
    ASSERT_EQ(graph.nodes.size(), 3u);
    EXPECT_EQ(graph.nodes[0].name, "samples");
    EXPECT_EQ(graph.nodes[1].name, "filter");
    EXPECT_EQ(graph.nodes[2].name, "write");
    EXPECT_EQ(sources(graph, "filter", "samples"), "samples.samples");
    EXPECT_EQ(sources(graph, "write", "image"), "filter.color");
    EXPECT_EQ(graph.about, "read, filter, write");
}

TEST(load, parameters_are_filled_in_and_defaults_too) {
    const Graph graph = graph_of(plain);
    EXPECT_EQ(param(graph, "samples", "file"), Json("analytic:garden"));
    EXPECT_EQ(param(graph, "filter", "width"), Json(3));
    EXPECT_EQ(param(graph, "filter", "filter"), Json("tent"));
    EXPECT_EQ(param(graph, "filter", "channels"), Json::list({"rgb"}));
    EXPECT_EQ(param(graph, "write", "file"), Json("out/a.exr"));
    EXPECT_EQ(param(graph, "write", "half"), Json(true));
    ASSERT_EQ(graph.parameters.size(), 3u);
    EXPECT_EQ(graph.parameters[1].value, Json(3));
}

TEST(load, a_node_knows_where_its_name_stands) {
    const Graph graph = graph_of(plain);
    EXPECT_EQ(where(graph.nodes[0].place), "test.json:12:5");
}

}  // namespace
}  // namespace weft
