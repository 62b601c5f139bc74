// Sample files and parts of the corpora, written by hand or found by fuzzing, are read or refused without
// harm; so is every beginning of them.
#include "part_fuzz.h"
#include "replay.h"
#include "sample_fuzz.h"

namespace weft {
namespace {

TEST(Fuzz, npz_of_the_corpus) {
    test::replay("npz", 4, test::fuzz_npz);
}
TEST(Fuzz, deep_exr_of_the_corpus) {
    test::replay("deep_exr", 4, test::fuzz_deep_exr);
}
TEST(Fuzz, tlfr_of_the_corpus) {
    test::replay("tlfr", 4, test::fuzz_tlfr);
}
TEST(Fuzz, ilfr_of_the_corpus) {
    test::replay("ilfr", 4, test::fuzz_ilfr);
}
TEST(Fuzz, parts_of_the_corpus) {
    test::replay("part", 4, test::fuzz_part);
}

}  // namespace
}  // namespace weft
