// The flattened document: reads back as the same graph, and does not know where pictures were
// written.
#include <gtest/gtest.h>

#include "graph_of.h"

namespace weft {
namespace {

using test::Folder;
using test::graph_of;
using test::load;

void expect_equal(const Graph& a, const Graph& b) {
    ASSERT_EQ(test::names(a), test::names(b));
    for (size_t i = 0; i < a.nodes.size(); ++i) {
        EXPECT_EQ(a.nodes[i].type, b.nodes[i].type);
        EXPECT_EQ(a.nodes[i].expressions, b.nodes[i].expressions) << a.nodes[i].name;
        for (size_t p = 0; p < a.nodes[i].params.size(); ++p)
            if (a.nodes[i].expressions[p].is(Json::Kind::null)) {
                EXPECT_EQ(a.nodes[i].params[p], b.nodes[i].params[p]) << a.nodes[i].name;
            }
        for (const PortDecl& port : a.nodes[i].type->inputs)
            EXPECT_EQ(test::sources(a, a.nodes[i].name, port.name),
                      test::sources(b, b.nodes[i].name, port.name));
    }
    ASSERT_EQ(a.outputs.size(), b.outputs.size());
    for (const auto& [name, link] : a.outputs) {
        EXPECT_EQ(link.node, b.outputs.at(name).node);
        EXPECT_EQ(link.port, b.outputs.at(name).port);
    }
    EXPECT_EQ(a.about, b.about);
}

class Flattened : public testing::Test {
  protected:
    Flattened() {
        folder.write("parts/both.json", R"({
          "weft": 1,
          "parameters": {"file": {"type": "file", "default": "both.exr"}, "passes": {"type": "integer", "default": 2}},
          "inputs": {"color": {"type": "Image"}},
          "outputs": {"color": "filter"},
          "nodes": {
            "filter": {"type": "bilateral-filter", "in": {"color": "color"}, "set": {"passes": "$passes"}},
            "float":  {"type": "write-image", "in": {"image": "filter"}, "set": {"file": "$file", "half": false}},
            "small":  {"type": "write-image", "in": {"image": "filter"}, "set": {"file": "${file.stem}.png"}}
          }
        })");
    }
    Graph graph(std::vector<std::string> set = {}, std::vector<std::string> swap = {}) const {
        LoadOptions options;
        options.overrides.set = std::move(set);
        options.overrides.swap = std::move(swap);
        options.for_run = true;
        return graph_of(R"({
          "weft": 1,
          "about": "two pictures, some files",
          "parameters": {
            "in":     {"type": "file", "default": "a$b.npz", "about": "read"},
            "passes": {"type": "integer", "default": 3, "minimum": 1},
            "kind":   {"type": "choice", "choices": ["x", "y"], "default": "x"},
            "out":    {"type": "file", "default": "out/a.exr", "about": "written"}
          },
          "nodes": {
            "samples": {"type": "read-samples", "set": {"file": "$in"}},
            "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}},
            "first":   {"type": "parts/both.json", "in": {"color": "filter"}, "set": {"file": "${out.stem}-1.exr", "passes": "$passes"}},
            "second":  {"type": "parts/both.json", "in": {"color": "first.color"}},
            "sheet":   {"type": "contact-sheet", "in": {"pictures": ["first", "second"]}, "set": {"title": "5$$ ${in}"}},
            "write":   {"type": "write-image", "in": {"image": "sheet"}, "set": {"file": "${out}"}},
            "last":    {"type": "write-image", "in": {"image": "sheet"}, "set": {"file": "x/${kind}-${passes}.exr"}}
          },
          "outputs": {"picture": "sheet"}
        })",
                        options, folder / "top.json");
    }
    Folder folder;
};

TEST_F(Flattened, reads_back_as_the_same_graph) {
    const Graph before = graph({"passes=5", "in=other.npz"});
    const std::string text = before.flattened().dump(true);
    const Graph after = graph_of(text, {}, "picture.exr");
    expect_equal(before, after);
    EXPECT_EQ(after.flattened().dump(true), text);
    EXPECT_EQ(test::param(after, "sheet", "title"), Json("5$ other.npz"));
}

TEST_F(Flattened, keeps_names_of_written_files_as_expressions_of_parameters) {
    const Json flat = graph({"passes=5"}).flattened();
    const auto file = [&](const char* node) {
        return flat.find("nodes")->find(node)->find("set")->find("file")->text;
    };
    EXPECT_EQ(file("first/float"), "${out.stem}-1.exr");
    EXPECT_EQ(file("first/small"), "${out.stem}-1.png");
    EXPECT_EQ(file("second/float"), "both.exr");
    EXPECT_EQ(file("second/small"), "both.png");
    EXPECT_EQ(file("write"), "${out}");
    EXPECT_EQ(file("last"), "x/${kind}-${passes}.exr");
    EXPECT_EQ(file("samples"), "a$$b.npz");
    const Json& parameters = *flat.find("parameters");
    EXPECT_EQ(parameters.find("in"), nullptr);
    EXPECT_EQ(*parameters.find("out")->find("default"), Json("out/a.exr"));
    EXPECT_EQ(*parameters.find("passes")->find("default"), Json(3));
    EXPECT_EQ(*flat.find("nodes")->find("first/filter")->find("set")->find("passes"), Json(5));
}

TEST_F(Flattened, is_the_same_text_wherever_pictures_are_written) {
    const std::string text = graph().flattened().dump();
    EXPECT_EQ(graph({"out=elsewhere/b.exr"}).flattened().dump(), text);
    EXPECT_EQ(graph({"write.file=c.exr"}).flattened().dump(), text);
    EXPECT_EQ(graph({"first.file=c.exr", "second/small.file=d.png"}).flattened().dump(), text);
    EXPECT_NE(graph({"in=c.npz"}).flattened().dump(), text);
}

TEST_F(Flattened, set_still_names_the_files_of_a_repeated_run) {
    LoadOptions options;
    options.overrides.set = {"out=new/p.exr"};
    const Graph again = graph_of(graph({"out=old.exr"}).flattened().dump(), options, "picture.exr");
    EXPECT_EQ(test::param(again, "first/small", "file"), Json("new/p-1.png"));
    EXPECT_EQ(test::param(again, "write", "file"), Json("new/p.exr"));
}

TEST_F(Flattened, swapped_and_bypassed_nodes_are_in_it_as_they_were_run) {
    LoadOptions options;
    options.overrides.bypass = {"first/filter"};
    options.overrides.swap = {"second/filter=median-filter,passes=1"};
    const std::string text = R"({"weft": 1, "nodes": {
      "samples": {"type": "read-samples", "set": {"file": "a"}},
      "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}},
      "first":   {"type": "parts/both.json", "in": {"color": "filter"}},
      "second":  {"type": "parts/both.json", "in": {"color": "first.color"}}},
      "outputs": {"color": "second"}})";
    const Graph before = graph_of(text, options, folder / "top.json");
    const Json flat = before.flattened();
    EXPECT_EQ(flat.find("nodes")->find("first/filter"), nullptr);
    EXPECT_EQ(*flat.find("nodes")->find("second/filter")->find("type"), Json("median-filter@1"));
    expect_equal(before, graph_of(flat.dump(), {}, "x"));
}

TEST_F(Flattened, a_file_that_only_an_option_named_becomes_a_parameter) {
    const std::string text = R"({"weft": 1, "nodes": {
      "samples": {"type": "read-samples", "set": {"file": "a"}},
      "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}},
      "write":   {"type": "write-image", "in": {"image": "filter"}}}})";
    const auto with = [&](const char* file) {
        LoadOptions options;
        options.overrides.set = {std::string("write.file=") + file};
        return graph_of(text, options);
    };
    const std::string flat = with("a.exr").flattened().dump();
    EXPECT_EQ(flat, with("b.exr").flattened().dump());
    const Loaded again = load(flat);
    EXPECT_TRUE(again.ok());
    LoadOptions options;
    options.for_run = true;
    EXPECT_FALSE(load(flat, options).ok());
    options.overrides.set = {"write-file=c.exr"};
    EXPECT_EQ(test::param(graph_of(flat, options), "write", "file"), Json("c.exr"));
}

TEST_F(Flattened, a_stem_that_cannot_be_written_down_is_the_value) {
    folder.write("stems.json", R"({
      "weft": 1,
      "parameters": {"file": {"type": "file"}},
      "inputs": {"color": {"type": "Image"}},
      "nodes": {"write": {"type": "write-image", "in": {"image": "color"}, "set": {"file": "${file.stem}.png"}}}
    })");
    const Graph g = graph_of(R"({"weft": 1,
      "parameters": {"out": {"type": "file", "default": "a.b.exr"}},
      "nodes": {
        "samples": {"type": "read-samples", "set": {"file": "a"}},
        "filter":  {"type": "pixel-filter", "in": {"samples": "samples"}},
        "part":    {"type": "stems.json", "in": {"color": "filter"}, "set": {"file": "${out.stem}"}}}})",
                             {}, folder / "top.json");
    EXPECT_EQ(test::param(g, "part/write", "file"), Json("a.png"));
    EXPECT_EQ(g.nodes.back().expressions[0], Json("a.png"));
}

}  // namespace
}  // namespace weft
