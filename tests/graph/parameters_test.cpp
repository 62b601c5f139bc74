// Parameters of a graph: whole values, parts of texts, through graphs used as nodes.
#include <gtest/gtest.h>

#include "graph/substitution.h"
#include "graph_of.h"

namespace weft {
namespace {

using namespace loading;

using test::Folder;
using test::graph_of;
using test::param;

std::string pieces(std::string_view text) {
    const Pieces p = take_apart(text);
    if (!p.problem.empty()) return "!";
    std::string out = p.whole ? "=" : "";
    for (const Piece& piece : p.list)
        out += (piece.parameter ? piece.stem ? "<%" : "<" : "[") + piece.text +
               (piece.parameter ? ">" : "]");
    return out;
}

TEST(parameters, a_text_is_taken_apart) {
    EXPECT_EQ(pieces("plain"), "[plain]");
    EXPECT_EQ(pieces(""), "");
    EXPECT_EQ(pieces("$name"), "=<name>");
    EXPECT_EQ(pieces("${name}"), "<name>");
    EXPECT_EQ(pieces("a/${name}.${n-2}"), "[a/]<name>[.]<n-2>");
    EXPECT_EQ(pieces("${name.stem}.png"), "<%name>[.png]");
    EXPECT_EQ(pieces("5$$ and $${x}"), "[5$ and ${x}]");
    EXPECT_EQ(pieces("$$"), "[$]");
    for (const char* wrong :
         {"$", "5$", "$a b", "a$b", "${", "${a", "${}", "${a.b}", "${a.stem.stem}", "${.stem}"})
        EXPECT_EQ(pieces(wrong), "!") << wrong;
}

TEST(parameters, a_stem_is_a_path_without_its_extension) {
    EXPECT_EQ(stem("out/a.exr"), "out/a");
    EXPECT_EQ(stem("a.b.exr"), "a.b");
    EXPECT_EQ(stem("dir.d/file"), "dir.d/file");
    EXPECT_EQ(stem(".hidden"), ".hidden");
    EXPECT_EQ(stem("a/.hidden"), "a/.hidden");
    EXPECT_EQ(stem(""), "");
}

TEST(parameters, escaped_text_reads_as_itself) {
    for (const char* text : {"$x", "a${b}", "$$", "plain", ""}) {
        const Pieces p = take_apart(escaped(Json(text)).text);
        EXPECT_EQ(p.problem, "");
        EXPECT_EQ(p.list.empty() ? "" : p.list[0].text, text);
    }
}

const char* const document = R"({
  "weft": 1,
  "parameters": {
    "in":     {"type": "file", "default": "data/shot.0001.npz"},
    "passes": {"type": "integer", "default": 3},
    "width":  {"type": "number", "default": 1.5},
    "red":    {"type": "number", "default": 0.25},
    "names":  {"type": "list", "default": ["rgb", "z"]},
    "kind":   {"type": "choice", "choices": ["tent", "gauss"], "default": "gauss"},
    "out":    {"type": "file", "default": "out/a.exr"}
  },
  "nodes": {
    "samples": {"type": "read-samples", "set": {"file": "$in"}},
    "filter":  {"type": "pixel-filter", "in": {"samples": "samples"},
                "set": {"width": "$width", "filter": "$kind", "channels": "$names"}},
    "smooth":  {"type": "bilateral-filter", "in": {"color": "filter"},
                "set": {"sigma-space": "$passes", "passes": "$passes", "tint": ["$red", 0.5, "$passes"]}},
    "sheet":   {"type": "contact-sheet", "in": {"pictures": ["smooth"]},
                "set": {"title": "${kind} x${passes} $$${width} of ${in.stem}"}},
    "write":   {"type": "write-image", "in": {"image": "sheet"}, "set": {"file": "${out.stem}-${passes}.png"}}
  }
})";

TEST(parameters, values_come_whole_or_within_texts_and_lists) {
    const Graph graph = graph_of(document);
    EXPECT_EQ(param(graph, "samples", "file"), Json("data/shot.0001.npz"));
    EXPECT_EQ(param(graph, "filter", "width"), Json(1.5));
    EXPECT_EQ(param(graph, "filter", "filter"), Json("gauss"));
    EXPECT_EQ(param(graph, "filter", "channels"), Json::list({"rgb", "z"}));
    EXPECT_EQ(param(graph, "smooth", "sigma-space"), Json(3));
    EXPECT_EQ(param(graph, "smooth", "tint"), Json::list({0.25, 0.5, 3}));
    EXPECT_EQ(param(graph, "sheet", "title"), Json("gauss x3 $1.5 of data/shot.0001"));
    EXPECT_EQ(param(graph, "write", "file"), Json("out/a-3.png"));
}

TEST(parameters, one_without_a_value_is_some_value_to_the_checker_and_an_error_to_a_run) {
    const char* const text = R"({
      "weft": 1,
      "parameters": {"in": {"type": "file"}, "out": {"type": "file"}, "n": {"type": "integer"}},
      "nodes": {
        "samples": {"type": "read-samples", "set": {"file": "$in"}},
        "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}, "set": {"width": "$n"}},
        "write":   {"type": "write-image", "in": {"image": "filter"}, "set": {"file": "${out.stem}-${n}.png"}}
      }
    })";
    const Graph graph = graph_of(text);
    EXPECT_TRUE(param(graph, "samples", "file").is(Json::Kind::null));
    EXPECT_TRUE(param(graph, "filter", "width").is(Json::Kind::null));
    LoadOptions run;
    run.for_run = true;
    EXPECT_EQ(test::load(text, run).findings.size(), 3u);
    run.overrides.set = {"in=a.npz", "out=b.exr", "n=4"};
    EXPECT_EQ(param(graph_of(text, run), "write", "file"), Json("b-4.png"));
}

TEST(parameters, a_graph_used_as_a_node_has_parameters_of_its_own) {
    Folder folder;
    folder.write("inner.json", R"({
      "weft": 1,
      "parameters": {"file": {"type": "file"}, "name": {"type": "text", "default": "$$plain"}},
      "inputs": {"image": {"type": "Image"}},
      "nodes": {
        "sheet": {"type": "contact-sheet", "in": {"pictures": ["image"]}, "set": {"title": "$name"}},
        "write": {"type": "write-image", "in": {"image": "sheet"}, "set": {"file": "${file.stem}-inner.png"}}
      }
    })");
    folder.write("outer.json", R"({
      "weft": 1,
      "parameters": {"to": {"type": "file"}},
      "inputs": {"image": {"type": "Image"}},
      "nodes": {"inner": {"type": "inner.json", "in": {"image": "image"}, "set": {"file": "${to.stem}-outer.exr"}}}
    })");
    const Graph graph = graph_of(R"({
      "weft": 1,
      "parameters": {"out": {"type": "file", "default": "x/y.z.exr"}},
      "nodes": {
        "samples": {"type": "read-samples", "set": {"file": "a.npz"}},
        "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}},
        "outer":   {"type": "outer.json", "in": {"image": "filter"}, "set": {"to": "$out"}}
      }
    })",
                                 {}, folder / "top.json");
    EXPECT_EQ(param(graph, "outer/inner/write", "file"), Json("x/y.z-outer-inner.png"));
    EXPECT_EQ(param(graph, "outer/inner/sheet", "title"),
              Json("$$plain"));  // a default is taken as it is
}

}  // namespace
}  // namespace weft
