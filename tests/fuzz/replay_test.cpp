// Every input kept in the corpora, found by fuzzing or written by hand, is handled without harm.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "graph_fuzz.h"

namespace weft {
namespace {

TEST(fuzz, graphs_of_the_corpus) {
    int count = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(WEFT_SOURCE_DIR "/tests/fuzz/corpus/graph")) {
        std::ifstream in(entry.path(), std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(in), {}};
        SCOPED_TRACE(entry.path().string());
        test::fuzz_graph(text);
        for (size_t cut = 0; cut < text.size(); cut += 1 + text.size() / 97)
            test::fuzz_graph(text.substr(0, cut));
        ++count;
    }
    EXPECT_GT(count, 20);
}

}  // namespace
}  // namespace weft
