// --set, --swap and --bypass: what they change in a graph that is otherwise left as it is.
#include <gtest/gtest.h>

#include "graph_of.h"

namespace weft {
namespace {

using test::Folder;
using test::graph_of;
using test::load;
using test::names;
using test::param;
using test::sources;

const char* const document = R"({
  "weft": 1,
  "parameters": {
    "width": {"type": "number", "default": 2, "minimum": 0.5},
    "out":   {"type": "file", "default": "a.exr"}
  },
  "nodes": {
    "samples": {"type": "read-samples", "set": {"file": "a.npz"}},
    "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}, "set": {"width": "$width"}},
    "smooth":  {"type": "bilateral-filter", "in": {"color": "filter.color", "guide": "filter.color"},
                "set": {"passes": 3, "sigma-range": 5}},
    "write":   {"type": "write-image", "in": {"image": "smooth.color"}, "set": {"file": "$out"}}
  }
})";

Graph changed(std::vector<std::string> set, std::vector<std::string> swap = {},
              std::vector<std::string> bypass = {}, const std::string& text = document,
              const std::string& name = "test.json") {
    LoadOptions options;
    options.overrides = {std::move(set), std::move(swap), std::move(bypass)};
    return graph_of(text, options, name);
}

TEST(options, set_gives_parameters_of_the_graph_and_of_nodes) {
    const Graph graph =
        changed({"width=3.5", "out=b.exr", "smooth.passes=4", "samples.file=7",
                 "filter.filter=tent", "smooth.tint=[1, 0.5, 0]", "write.half=false"});
    EXPECT_EQ(param(graph, "filter", "width"), Json(3.5));
    EXPECT_EQ(graph.parameters[0].value, Json(3.5));
    EXPECT_EQ(param(graph, "write", "file"), Json("b.exr"));
    EXPECT_EQ(param(graph, "smooth", "passes"), Json(4));
    EXPECT_EQ(param(graph, "samples", "file"),
              Json("7"));  // a text even where it reads as a number
    EXPECT_EQ(param(graph, "filter", "filter"), Json("tent"));
    EXPECT_EQ(param(graph, "smooth", "tint"), Json::list({1, 0.5, 0}));
    EXPECT_EQ(param(graph, "write", "half"), Json(false));
}

TEST(options, a_value_keeps_its_dollars_equals_signs_and_quotes) {
    EXPECT_EQ(param(changed({"out=a=b$c.exr"}), "write", "file"), Json("a=b$c.exr"));
    EXPECT_EQ(param(changed({"out=\"quoted.exr\""}), "write", "file"), Json("quoted.exr"));
}

TEST(options, the_last_of_two_counts) {
    EXPECT_EQ(param(changed({"width=3", "width=4"}), "filter", "width"), Json(4));
}

TEST(options, a_node_within_a_graph_is_reached_by_its_path) {
    Folder folder;
    folder.write("part.json", R"({
      "weft": 1,
      "parameters": {"range": {"type": "number", "default": 0.5}},
      "inputs": {"color": {"type": "Image"}},
      "outputs": {"color": "b"},
      "nodes": {
        "a": {"type": "bilateral-filter", "in": {"color": "color"}, "set": {"sigma-range": "$range"}},
        "b": {"type": "bilateral-filter", "in": {"color": "a"}, "set": {"sigma-range": "$range"}}
      }
    })");
    const std::string text = R"({"weft": 1, "nodes": {
      "samples": {"type": "read-samples", "set": {"file": "a.npz"}},
      "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}},
      "part":    {"type": "part.json", "in": {"color": "filter"}},
      "write":   {"type": "write-image", "in": {"image": "part"}, "set": {"file": "a.exr"}}}})";
    const Graph graph =
        changed({"part.range=2", "part/b.sigma-range=3"}, {}, {}, text, folder / "top.json");
    EXPECT_EQ(param(graph, "part/a", "sigma-range"), Json(2));
    EXPECT_EQ(param(graph, "part/b", "sigma-range"), Json(3));
    EXPECT_EQ(names(changed({}, {}, {"part/a"}, text, folder / "top.json")),
              "samples filter part/b write");
    EXPECT_EQ(names(changed({}, {}, {"part"}, text, folder / "top.json")), "samples filter write");
    const Graph swapped =
        changed({}, {"part/a=median-filter,passes=4"}, {}, text, folder / "top.json");
    EXPECT_EQ(sources(swapped, "part/b", "color"), "part/a.picture");
    EXPECT_EQ(param(swapped, "part/a", "passes"), Json(4));
}

TEST(options, swap_keeps_what_the_new_type_has_and_drops_the_rest) {
    const Graph graph = changed({}, {"smooth=median-filter"});
    EXPECT_EQ(graph.nodes[size_t(graph.find("smooth"))].type->type, "median-filter");
    EXPECT_EQ(sources(graph, "smooth", "color"), "filter.color");
    EXPECT_EQ(param(graph, "smooth", "passes"), Json(3));
    EXPECT_EQ(sources(graph, "write", "image"), "smooth.picture");  // the only output of that type
}

TEST(options, swap_gives_parameters_and_set_comes_after) {
    EXPECT_EQ(param(changed({}, {"smooth=median-filter,passes=1"}), "smooth", "passes"), Json(1));
    EXPECT_EQ(
        param(changed({"smooth.passes=2"}, {"smooth=median-filter,passes=1"}), "smooth", "passes"),
        Json(2));
    const Graph graph = changed({}, {"smooth=bilateral-filter,tint=[0, 1, 2],passes=2"});
    EXPECT_EQ(param(graph, "smooth", "tint"), Json::list({0, 1, 2}));
    EXPECT_EQ(param(graph, "smooth", "passes"), Json(2));
}

TEST(options, swap_takes_a_graph_as_well) {
    Folder folder;
    folder.write("two.json", R"({
      "weft": 1,
      "parameters": {"passes": {"type": "integer", "default": 1}},
      "inputs": {"color": {"type": "Image"}},
      "outputs": {"done": "b"},
      "nodes": {
        "a": {"type": "median-filter", "in": {"color": "color"}, "set": {"passes": "$passes"}},
        "b": {"type": "median-filter", "in": {"color": "a"}}
      }
    })");
    const Graph graph = changed({}, {"smooth=two.json"}, {}, document, folder / "top.json");
    EXPECT_EQ(names(graph), "samples filter smooth/a smooth/b write");
    EXPECT_EQ(sources(graph, "smooth/a", "color"), "filter.color");
    EXPECT_EQ(sources(graph, "write", "image"), "smooth/b.picture");
    EXPECT_EQ(param(graph, "smooth/a", "passes"), Json(3));
    EXPECT_EQ(names(changed({}, {"smooth=" + (folder / "two.json")})),
              "samples filter smooth/a smooth/b write");
}

TEST(options, swap_tells_what_the_new_type_offers_where_a_link_is_lost) {
    LoadOptions options;
    options.overrides.swap = {"smooth=split-image"};
    EXPECT_EQ(test::short_text(load(document, options).findings),
              "--swap smooth=split-image: 'split-image' has nothing for the link 'smooth.color' "
              "(Image); it has "
              "'smooth.low' (Image), 'smooth.high' (Image), 'smooth.error' (Table)\n");
}

TEST(options, bypass_takes_a_node_out) {
    const Graph graph = changed({}, {}, {"smooth"});
    EXPECT_EQ(names(graph), "samples filter write");
    EXPECT_EQ(sources(graph, "write", "image"), "filter.color");
}

TEST(options, a_parameter_that_a_swap_drops_is_not_unused) {
    const std::string text = R"({"weft": 1,
      "parameters": {"range": {"type": "number", "default": 1}},
      "nodes": {
        "samples": {"type": "read-samples", "set": {"file": "a.npz"}},
        "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}},
        "guide":   {"type": "median-filter", "in": {"color": "filter"}},
        "smooth":  {"type": "bilateral-filter", "in": {"color": "filter", "guide": "guide"}, "set": {"sigma-range": "$range"}},
        "write":   {"type": "write-image", "in": {"image": "smooth"}, "set": {"file": "a.exr"}}}})";
    EXPECT_EQ(names(changed({}, {"smooth=median-filter"}, {}, text)),
              "samples filter guide smooth write");
}

}  // namespace
}  // namespace weft
