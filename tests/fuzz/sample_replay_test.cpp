// Sample files and parts of the corpora, written by hand or found by fuzzing, are read or refused without
// harm; so is every beginning of them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "part_fuzz.h"
#include "sample_fuzz.h"

namespace weft {
namespace {

void replay(const std::string& name, void (*fuzz)(std::string_view)) {
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
    EXPECT_GE(count, 4);
}

TEST(Fuzz, npz_of_the_corpus) {
    replay("npz", test::fuzz_npz);
}
TEST(Fuzz, deep_exr_of_the_corpus) {
    replay("deep_exr", test::fuzz_deep_exr);
}
TEST(Fuzz, tlfr_of_the_corpus) {
    replay("tlfr", test::fuzz_tlfr);
}
TEST(Fuzz, ilfr_of_the_corpus) {
    replay("ilfr", test::fuzz_ilfr);
}
TEST(Fuzz, parts_of_the_corpus) {
    replay("part", test::fuzz_part);
}

}  // namespace
}  // namespace weft
