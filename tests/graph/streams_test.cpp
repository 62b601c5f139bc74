// Streams that may meet: forks, selections that are merged, what a batch shares.
#include <gtest/gtest.h>

#include "graph_of.h"

namespace weft {
namespace {

using test::graph_of;

std::string with(const std::string& nodes) {
    return R"({"weft": 1, "nodes": {
      "samples":   {"type": "read-samples", "set": {"file": "a.npz"}},
      "locations": {"type": "output-locations", "in": {"samples": "samples"}},
      "reproject": {"type": "reproject", "in": {"locations": "locations", "samples": "samples"}},
      "coverage":  {"type": "coverage", "in": {"candidates": "reproject", "slice": "locations"}},
      )" + nodes +
           R"(,
      "write":     {"type": "write-image", "in": {"image": "accumulate"}, "set": {"file": "out.exr"}}}})";
}

TEST(streams, a_stream_forks_and_joins_itself) {
    graph_of(with(
        R"("mix": {"type": "mix-colors", "in": {"a": "coverage.colors", "b": "coverage.colors"}},
                     "accumulate": {"type": "accumulate", "in": {"colors": "mix"}})"));
}

TEST(streams, selections_of_selections_are_merged_back_one_by_one) {
    const Graph graph = graph_of(with(R"(
      "reproject-2": {"type": "reproject", "in": {"locations": "coverage.undecided", "samples": "samples"}},
      "coverage-2":  {"type": "coverage", "in": {"candidates": "reproject-2", "slice": "locations.slice"}},
      "reproject-3": {"type": "reproject", "in": {"locations": "coverage-2.undecided", "samples": "samples"}},
      "coverage-3":  {"type": "coverage", "in": {"candidates": "reproject-3"}},
      "settled":     {"type": "merge-colors", "in": {"first": "coverage-2", "again": "coverage-3"}},
      "merge":       {"type": "merge-colors", "in": {"first": "coverage", "again": "settled"}},
      "accumulate":  {"type": "accumulate", "in": {"colors": "merge"}})"));
    EXPECT_EQ(test::sources(graph, "merge", "first"), "coverage.colors");
    EXPECT_EQ(test::sources(graph, "reproject-2", "locations"), "coverage.undecided");
}

// Its records are counted within those it was selected from: their places in the whole are not
// known.
TEST(streams, a_selection_of_a_selection_is_no_branch_of_the_whole) {
    const Loaded loaded = test::load(with(R"(
      "reproject-2": {"type": "reproject", "in": {"locations": "coverage.undecided", "samples": "samples"}},
      "coverage-2":  {"type": "coverage", "in": {"candidates": "reproject-2"}},
      "reproject-3": {"type": "reproject", "in": {"locations": "coverage-2.undecided", "samples": "samples"}},
      "coverage-3":  {"type": "coverage", "in": {"candidates": "reproject-3"}},
      "merge":       {"type": "merge-colors", "in": {"first": "coverage", "again": "coverage-2", "last": "coverage-3"}},
      "accumulate":  {"type": "accumulate", "in": {"colors": "merge"}})"));
    ASSERT_EQ(loaded.findings.size(), 1u);
    EXPECT_EQ(loaded.findings[0].message,
              "'coverage-3.colors' holds the records that 'coverage-2.undecided' selects, which "
              "were not selected from "
              "'first' (all records of 'locations'); 'last' takes a branch of it");
}

// What the inputs of a part have in common is seen where it is used.
TEST(streams, a_part_may_join_its_inputs) {
    const char* const part = R"({"weft": 1,
      "inputs": {"colors": {"type": "Colors"}, "undecided": {"type": "Locations"}, "samples": {"type": "Samples"}},
      "outputs": {"colors": "merge"},
      "nodes": {
        "reproject": {"type": "reproject", "in": {"locations": "undecided", "samples": "samples"}},
        "coverage":  {"type": "coverage", "in": {"candidates": "reproject"}},
        "merge":     {"type": "merge-colors", "in": {"first": "colors", "again": "coverage"}}}})";
    graph_of(part);
    test::Folder folder;
    folder.write("part.json", part);
    const auto used = [&](const std::string& undecided) {
        return test::load(with(R"(
          "retry": {"type": "part.json", "in": {"colors": "coverage", "undecided": ")" +
                               undecided + R"(", "samples": "samples"}},
          "accumulate": {"type": "accumulate", "in": {"colors": "retry"}})"),
                          {}, folder / "top.json")
            .findings.size();
    };
    EXPECT_EQ(used("coverage.undecided"), 0u);
    EXPECT_EQ(used("locations.locations"), 1u);
}

TEST(streams, a_stream_may_read_what_came_of_another_stream) {
    graph_of(with(R"(
      "first":       {"type": "accumulate", "in": {"colors": "coverage"}},
      "locations-2": {"type": "output-locations", "in": {"samples": "samples"}},
      "reproject-2": {"type": "reproject", "in": {"locations": "locations-2", "samples": "samples"}},
      "coverage-2":  {"type": "coverage", "in": {"candidates": "reproject-2"}},
      "tint":        {"type": "tint-colors", "in": {"colors": "coverage-2", "by": "first"}},
      "accumulate":  {"type": "accumulate", "in": {"colors": "tint"}})"));
}

// Neither of two streams waits for itself, but each for the other.
TEST(streams, two_streams_that_wait_for_each_other_are_found) {
    const Loaded loaded = test::load(with(R"(
      "first":       {"type": "accumulate", "in": {"colors": "coverage"}},
      "locations-2": {"type": "output-locations", "in": {"samples": "samples"}},
      "reproject-2": {"type": "reproject", "in": {"locations": "locations-2", "samples": "samples"}},
      "coverage-2":  {"type": "coverage", "in": {"candidates": "reproject-2"}},
      "tint-2":      {"type": "tint-colors", "in": {"colors": "coverage-2", "by": "first"}},
      "second":      {"type": "accumulate", "in": {"colors": "tint-2"}},
      "other":       {"type": "accumulate", "in": {"colors": "coverage-2"}},
      "tint":        {"type": "tint-colors", "in": {"colors": "coverage", "by": "other"}},
      "third":       {"type": "accumulate", "in": {"colors": "tint"}},
      "accumulate":  {"type": "contact-sheet", "in": {"pictures": ["second", "third"]}})"));
    EXPECT_EQ(
        test::short_text(loaded.findings).find("is part of the stream of") != std::string::npos,
        true);
    EXPECT_EQ(loaded.findings.size(), 1u);
}

}  // namespace
}  // namespace weft
