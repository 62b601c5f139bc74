// The schema of documents, held against documents by a validator of its own (python3-jsonschema):
// every document the checker takes is valid, and what is wrong in its form is not.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "validator.h"

namespace weft {
namespace {

namespace fs = std::filesystem;

std::string verdicts(const test::Folder& folder, const std::vector<std::string>& documents) {
    return test::verdicts(folder, graph_schema(test::catalog()), documents);
}

TEST(schema, says_of_every_node_what_its_declaration_says) {
    const Json schema = graph_schema(test::catalog());
    const Json& node = *schema.find("$defs")->find("node:bilateral-filter");
    const Json& set = *node.find("properties")->find("set");
    EXPECT_EQ(*set.find("additionalProperties"), Json(false));
    const Json& range = *set.find("properties")->find("sigma-range");
    EXPECT_EQ(*range.find("default"), Json(0.1));
    EXPECT_EQ(range.find("description")->text, "a parameter of the tests (guide)");
    EXPECT_EQ(*range.find("anyOf")->items[0].find("maximum"), Json(1000));
    EXPECT_EQ(schema.find("$defs")->members.size(), 6 + test::catalog().all().size());
}

TEST(schema, accepts_what_the_checker_accepts) {
    if (test::python_with_jsonschema().empty()) GTEST_SKIP() << "no python3 with jsonschema";
    const test::Folder folder;
    std::vector<std::string> documents{folder.write("full.json", R"({
          "$schema": "graph.schema.json",
          "weft": 1, "about": "all there is", "layout": {"x": [1]},
          "parameters": {
            "in": {"type": "file"}, "n": {"type": "integer", "default": 2, "minimum": 1, "maximum": 5, "unit": "px", "about": "n"},
            "kind": {"type": "choice", "choices": ["tent"], "default": "tent"}, "names": {"type": "list", "default": []},
            "tint": {"type": "color", "default": [1, 2, 3]}, "half": {"type": "boolean", "default": true}
          },
          "inputs": {"guide": {"type": "Image", "optional": true, "about": "a guide"}},
          "outputs": {"picture": "smooth.color"},
          "nodes": {
            "samples": {"type": "read-samples@2", "set": {"file": "$in"}, "about": "read"},
            "filter": {"type": "pixel-filter", "in": {"samples": "samples"},
                       "set": {"width": "$n", "filter": "$kind", "channels": "$names"}},
            "a/b": {"type": "bilateral-filter@1", "in": {"color": "filter.color", "guide": "guide"},
                    "set": {"tint": "$tint", "passes": 2.0, "sigma-space": 0.1}},
            "smooth": {"type": "bilateral-filter", "in": {"color": "a/b"}, "set": {"tint": ["$n", 0, 1]}},
            "open": {"type": "bilateral-filter", "in": {"color": "smooth"}, "bypass": true},
            "many": {"type": "bilateral-filter", "each": {"tint": [[1, 1, 1], [2, 2, 2]]}, "carry": {"color": "color"}, "in": {"color": "open"}},
            "one": {"type": "contact-sheet", "in": {"pictures": "many"}, "set": {"title": "${in.stem} $$"}},
            "sheet": {"type": "contact-sheet", "in": {"pictures": ["one", "smooth.color"]}},
            "part": {"type": "parts/any.json", "in": {"color": "sheet"}, "set": {"range": [1, {"a": 2}]}},
            "write": {"type": "write-image", "in": {"image": "part"}, "set": {"file": "x.exr", "half": "$half"}}
          }})"),
                                       folder.write("empty.json", R"({"weft": 1, "nodes": {}})")};
    folder.write("parts/any.json", R"({"weft": 1,
      "parameters": {"range": {"type": "list"}},
      "inputs": {"color": {"type": "Image"}}, "outputs": {"color": "sheet"},
      "nodes": {"filter": {"type": "median-filter", "in": {"color": "color"}},
                "s": {"type": "read-samples", "set": {"file": "x"}},
                "p": {"type": "pixel-filter", "in": {"samples": "s"}, "set": {"channels": "$range"}},
                "sheet": {"type": "contact-sheet", "in": {"pictures": ["filter", "p"]}}}})");
    for (const std::string& document : documents)
        EXPECT_EQ(test::all_text(load_graph(document, test::catalog()).findings), "");
    EXPECT_EQ(verdicts(folder, documents), "full.json yes\nempty.json yes\n");
}

// A flattened document is one too.
TEST(schema, accepts_flattened_documents) {
    if (test::python_with_jsonschema().empty()) GTEST_SKIP() << "no python3 with jsonschema";
    const test::Folder folder;
    const Graph graph = test::graph_of(R"({"weft": 1,
      "parameters": {"out": {"type": "file", "default": "a.exr"}},
      "nodes": {
        "samples": {"type": "read-samples", "set": {"file": "a$$.npz"}},
        "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}},
        "write":   {"type": "write-image", "in": {"image": "filter"}, "set": {"file": "${out.stem}.png"}}}})");
    EXPECT_EQ(verdicts(folder, {folder.write("flat.json", graph.flattened().dump())}),
              "flat.json yes\n");
}

TEST(schema, refuses_what_is_wrong_in_form) {
    if (test::python_with_jsonschema().empty()) GTEST_SKIP() << "no python3 with jsonschema";
    const test::Folder folder;
    const fs::path errors = fs::path(WEFT_SOURCE_DIR) / "tests/errors";
    // What is broken in these can be seen without following links or reading other files.
    std::vector<std::string> files;
    std::string expected;
    for (const char* name :
         {"bad_names", "link_types", "missing", "no_nodes", "node_type", "node_version",
          "not_an_object", "parameters", "unknown_keys", "values", "version_later",
          "version_missing", "version_wrong", "wrong_kinds_of_json"}) {
        files.push_back((errors / (std::string(name) + ".json")).string());
        expected += std::string(name) + ".json no\n";
    }
    EXPECT_EQ(verdicts(folder, files), expected);

    const auto document = [](const std::string& node) {
        return R"({"weft": 1, "nodes": {"x": )" + node + "}}";
    };
    const std::vector<std::string> nodes{
        R"({"type": "pixel-filter", "in": {"samples": "s"}, "set": {"width": 65}})",
        R"({"type": "pixel-filter", "in": {"samples": "s"}, "set": {"width": "wide"}})",
        R"({"type": "pixel-filter", "in": {"samples": "s"}, "set": {"widht": 1}})",
        R"({"type": "pixel-filter", "in": {"sample": "s"}})",
        R"({"type": "pixel-filter", "in": {"samples": ["s"]}})",
        R"({"type": "pixel-filter"})",
        R"({"type": "pixel-filter", "in": {"samples": "s"}, "set": {"filter": "round"}})",
        R"({"type": "pixel-filter", "in": {"samples": "s"}, "mute": true})",
        R"({"type": "bilateral-filter", "in": {"color": "s"}, "set": {"passes": 1.5}})",
        R"({"type": "bilateral-filter", "in": {"color": "s"}, "set": {"tint": [1, 2]}})",
        R"({"type": "contact-sheet", "in": {"pictures": []}})",
        R"({"type": "read-samples", "set": {"file": ""}})",
        R"({"type": "read-samples"})",
        R"({"type": "read-samples@1", "set": {"file": "a"}})",
    };
    files.clear();
    expected.clear();
    for (size_t i = 0; i < nodes.size(); ++i) {
        const std::string name = fmt::format("n{:02}.json", i);
        files.push_back(folder.write(name, document(nodes[i])));
        expected += name + " no\n";
    }
    EXPECT_EQ(verdicts(folder, files), expected);
}

}  // namespace
}  // namespace weft
