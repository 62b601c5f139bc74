#include "scene_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, size_t size) {
    weft::test::fuzz_mtl(std::string_view(reinterpret_cast<const char*>(data), size));
    return 0;
}
