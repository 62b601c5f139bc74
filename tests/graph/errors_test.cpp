// Broken graphs, each with its messages beside it: tests/errors/NAME.json and NAME.expected.
// Lines "// --set x=1" at the top of a graph are options it is loaded with; "// run" loads it to
// run. With $WEFT_ACCEPT set the messages are written instead of compared: read them before you
// keep them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "graph_of.h"

namespace weft {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

LoadOptions options_of(const std::string& text) {
    LoadOptions options;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line) && line.rfind("// ", 0) == 0;) {
        const auto option = [&](const char* name, std::vector<std::string>& list) {
            const std::string start = std::string("// ") + name + " ";
            if (line.rfind(start, 0) == 0) list.push_back(line.substr(start.size()));
        };
        option("--set", options.overrides.set);
        option("--swap", options.overrides.swap);
        option("--bypass", options.overrides.bypass);
        if (line == "// run") options.for_run = true;
    }
    return options;
}

TEST(errors, every_broken_graph_has_its_messages) {
    const fs::path back = fs::current_path();
    fs::current_path(fs::path(WEFT_SOURCE_DIR) / "tests/errors");
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator("."))
        if (entry.path().extension() == ".json") files.push_back(entry.path().filename());
    std::sort(files.begin(), files.end());
    EXPECT_GT(files.size(), 30u);
    for (const fs::path& file : files) {
        const Loaded loaded = load_graph(file.string(), test::catalog(), options_of(text_of(file)));
        const std::string told = test::all_text(loaded.findings);
        EXPECT_NE(told, "") << file;
        fs::path beside = file;
        beside.replace_extension(".expected");
        if (std::getenv("WEFT_ACCEPT"))
            std::ofstream(beside) << told;
        else
            EXPECT_EQ(told, text_of(beside)) << file;
    }
    fs::current_path(back);
}

}  // namespace
}  // namespace weft
