// Scene files of the corpora, made by hand or found by fuzzing, are read or refused without harm;
// so is every beginning of them.
#include "replay.h"
#include "scene_fuzz.h"

namespace weft {
namespace {

TEST(Fuzz, gltf_of_the_corpus) {
    test::replay("gltf", 6, test::fuzz_gltf);
}
TEST(Fuzz, obj_of_the_corpus) {
    test::replay("obj", 3, test::fuzz_obj);
}
TEST(Fuzz, mtl_of_the_corpus) {
    test::replay("mtl", 3, test::fuzz_mtl);
}
TEST(Fuzz, json_scenes_of_the_corpus) {
    test::replay("json_scene", 3, test::fuzz_json_scene);
}

}  // namespace
}  // namespace weft
