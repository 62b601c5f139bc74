// The nodes of this program and the graphs it is shipped with, held against each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "runtime/registry.h"
#include "validator.h"

namespace weft {
namespace {

namespace fs = std::filesystem;

const Registry& registry() {
    return Registry::instance();
}

// Those that this build has the nodes for: WEFT_RPF is an option.
std::vector<std::string> shipped() {
    const bool has_rpf = Registry::instance().type("build-vectors") != nullptr;
    std::vector<std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(WEFT_SOURCE_DIR "/graphs")) {
        const fs::path& path = entry.path();
        if (path.extension() != ".json" || path.parent_path().filename() == "scenes") continue;
        if (has_rpf || !path.filename().string().starts_with("rpf")) files.push_back(path.string());
    }
    std::sort(files.begin(), files.end());
    return files;
}

bool is_kebab(const std::string& name) {
    return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
    });
}

TEST(all_nodes, no_two_share_a_name) {
    EXPECT_TRUE(registry().conflicts().empty());
}

TEST(all_nodes, every_declaration_is_whole) {
    EXPECT_GT(registry().all().size(), 10u);
    for (const NodeDecl* decl : registry().all()) {
        SCOPED_TRACE(decl->type);
        EXPECT_TRUE(is_kebab(decl->type));
        EXPECT_NE(decl->about, "");
        EXPECT_NE(decl->family, "");
        EXPECT_GE(decl->version, 1);
        EXPECT_TRUE(decl->writes || !decl->outputs.empty()) << "it can never be run";
        std::set<std::string> names;
        for (const PortDecl& port : decl->inputs) {
            EXPECT_TRUE(is_kebab(port.name) && names.insert(port.name).second) << port.name;
            EXPECT_NE(port.about, "") << port.name;
        }
        names.clear();
        for (const PortDecl& port : decl->outputs) {
            EXPECT_TRUE(is_kebab(port.name) && names.insert(port.name).second) << port.name;
            EXPECT_NE(port.about, "") << port.name;
        }
        names.clear();
        for (const ParamDecl& param : decl->params) {
            EXPECT_TRUE(is_kebab(param.name) && names.insert(param.name).second) << param.name;
            EXPECT_NE(param.about, "") << param.name;
            EXPECT_LE(param.minimum, param.maximum) << param.name;
            // A file to be named by the user has no default; every other default is a value in
            // range.
            const bool unnamed =
                param.kind == Kind::file && param.fallback && *param.fallback == Json("");
            if (param.fallback && !unnamed) {
                EXPECT_EQ(mismatch(param, *param.fallback), "");
            }
        }
    }
}

// Graphs that speak of them are told what is missing, in a build without.
TEST(all_nodes, those_of_random_parameter_filtering_name_their_option) {
    for (const NodeDecl* decl : registry().all())
        EXPECT_EQ(registry().option_of(decl->type), decl->family == "rpf" ? "WEFT_RPF" : "")
            << decl->type;
    EXPECT_EQ(registry().option_of("neighbourhoods"), "WEFT_RPF");
    if (registry().find("neighbourhoods")) return;
    const Loaded loaded = load_graph(WEFT_SOURCE_DIR "/graphs/rpf.json", registry());
    const std::string told = test::all_text(loaded.findings);
    EXPECT_NE(told.find("no node type 'neighbourhoods'; this build was made without it; "
                        "configure with -DWEFT_RPF=ON"),
              std::string::npos)
        << told;
}

TEST(all_nodes, shipped_graphs_are_in_order_and_read_back_when_flattened) {
    EXPECT_GT(shipped().size(), 10u);
    for (const std::string& file : shipped()) {
        SCOPED_TRACE(file);
        const Loaded loaded = load_graph(file, registry());
        EXPECT_EQ(test::all_text(loaded.findings), "");
        EXPECT_NE(loaded.graph.about, "");
        if (file.find("/parts/") != std::string::npos) continue;  // its inputs are not in it
        const std::string flat = loaded.graph.flattened().dump();
        const Loaded again = load_graph_text(flat, "flat.json", registry());
        EXPECT_TRUE(again.ok()) << test::all_text(again.findings);
        EXPECT_EQ(again.graph.flattened().dump(), flat);
    }
}

TEST(all_nodes, shipped_graphs_and_their_flattened_forms_fit_the_schema) {
    if (test::python_with_jsonschema().empty()) GTEST_SKIP() << "no python3 with jsonschema";
    const test::Folder folder;
    std::vector<std::string> files = shipped();
    const size_t count = files.size();
    for (size_t i = 0; i < count; ++i) {
        const Graph graph = load_graph(files[i], registry()).graph;
        files.push_back(
            folder.write("flat" + std::to_string(i) + ".json", graph.flattened().dump()));
        if (files[i].find("/parts/") != std::string::npos) files.pop_back();
    }
    const std::string told = test::verdicts(folder, graph_schema(registry()), files);
    EXPECT_EQ(told.find(" no\n"), std::string::npos) << told;
    EXPECT_EQ(size_t(std::count(told.begin(), told.end(), '\n')), files.size());
}

// Every broken graph of the catalog's own form is broken here too, whatever nodes it names.
TEST(all_nodes, broken_documents_do_not_fit_the_schema) {
    if (test::python_with_jsonschema().empty()) GTEST_SKIP() << "no python3 with jsonschema";
    const test::Folder folder;
    std::vector<std::string> files;
    std::string expected;
    for (const char* name : {"bad_names", "no_nodes", "not_an_object", "unknown_keys",
                             "version_later", "wrong_kinds_of_json"}) {
        files.push_back(std::string(WEFT_SOURCE_DIR "/tests/errors/") + name + ".json");
        expected += std::string(name) + ".json no\n";
    }
    EXPECT_EQ(test::verdicts(folder, graph_schema(registry()), files), expected);
}

}  // namespace
}  // namespace weft
