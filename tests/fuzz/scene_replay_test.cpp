// Scene files of the corpora, made by hand or found by fuzzing, are read or refused without harm;
// so is every beginning of them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "scene_fuzz.h"

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
    EXPECT_GE(count, 3);
}

TEST(Fuzz, gltf_of_the_corpus) {
    replay("gltf", test::fuzz_gltf);
}
TEST(Fuzz, obj_of_the_corpus) {
    replay("obj", test::fuzz_obj);
}
TEST(Fuzz, json_scenes_of_the_corpus) {
    replay("json_scene", test::fuzz_json_scene);
}

}  // namespace
}  // namespace weft
