// The graph parser on whatever bytes there are: it must come back with findings or a graph, and a
// graph that is in order must survive being flattened and drawn.
#include "graph_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, size_t size) {
    weft::test::fuzz_graph(std::string_view(reinterpret_cast<const char*>(data), size));
    return 0;
}
