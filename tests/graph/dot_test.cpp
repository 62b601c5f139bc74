// Pictures of a graph: sub-graphs as clusters, types on the edges, streams dashed.
#include <gtest/gtest.h>

#include "graph_of.h"

namespace weft {
namespace {

const char* const document = R"({"weft": 1, "nodes": {
  "samples":     {"type": "read-samples", "set": {"file": "a.npz"}},
  "p/locations": {"type": "output-locations", "in": {"samples": "samples"}},
  "p/q/again":   {"type": "reproject", "in": {"locations": "p/locations", "samples": "samples"}},
  "p/coverage":  {"type": "coverage", "in": {"candidates": "p/q/again"}},
  "accumulate":  {"type": "accumulate", "in": {"colors": "p/coverage"}}},
  "outputs": {"picture": "accumulate"}})";

TEST(dot, clusters_types_and_dashes) {
    EXPECT_EQ(to_dot(test::graph_of(document)), R"(digraph weft {
  rankdir=LR;
  node [shape=box, style=rounded, fontname="sans-serif"];
  edge [fontname="sans-serif", fontsize=10];
  n0 [label="samples\nread-samples"];
  n4 [label="accumulate\naccumulate"];
  subgraph "cluster_p" {
    label="p";
    n1 [label="locations\noutput-locations"];
    n3 [label="coverage\ncoverage"];
    subgraph "cluster_p/q" {
      label="q";
      n2 [label="again\nreproject"];
    }
  }
  n0 -> n1 [label="Samples"];
  n1 -> n2 [label="Locations", style=dashed];
  n0 -> n2 [label="Samples"];
  n2 -> n3 [label="Candidates", style=dashed];
  n3 -> n4 [label="Colors", style=dashed];
  o0 [label="picture", shape=ellipse];
  n4 -> o0 [label="Image"];
}
)");
}

TEST(dot, mermaid_says_the_same) {
    EXPECT_EQ(to_mermaid(test::graph_of(document)), R"(flowchart LR
  n0["samples<br/>read-samples"]
  n4["accumulate<br/>accumulate"]
  subgraph s0["p"]
    n1["locations<br/>output-locations"]
    n3["coverage<br/>coverage"]
    subgraph s1["q"]
      n2["again<br/>reproject"]
    end
  end
  n0 -->|"Samples"| n1
  n1 -.->|"Locations"| n2
  n0 -->|"Samples"| n2
  n2 -.->|"Candidates"| n3
  n3 -.->|"Colors"| n4
  o0(["picture"])
  n4 -->|"Image"| o0
)");
}

}  // namespace
}  // namespace weft
