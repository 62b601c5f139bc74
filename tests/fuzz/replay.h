// Runs a fuzz target over its corpus, tests/fuzz/corpus/<name>: every file, and up to 98 beginnings of each.
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace weft::test {

// `least`: files that the corpus must have.
inline void replay(const std::string& name, int least, void (*fuzz)(std::string_view)) {
    int count = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(WEFT_SOURCE_DIR "/tests/fuzz/corpus/" + name)) {
        std::ifstream in(entry.path(), std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(in), {}};
        SCOPED_TRACE(entry.path().string());
        fuzz(bytes);
        for (size_t cut = 0; cut < bytes.size(); cut += 1 + bytes.size() / 97)
            fuzz(std::string_view(bytes).substr(0, cut));
        ++count;
    }
    EXPECT_GE(count, least);
}

}  // namespace weft::test
