// Streams allocate nothing once every worker has seen a tile.
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "tests/runtime/toy_nodes.h"

namespace {
thread_local std::uint64_t allocations = 0;
}

// GCC sees malloc behind our new and free behind our delete, and warns where it inlines one of them.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"

void* operator new(size_t size) {
    ++allocations;
    if (void* memory = std::malloc(size ? size : 1)) return memory;
    throw std::bad_alloc();
}
void* operator new(size_t size, const std::nothrow_t&) noexcept {
    ++allocations;
    return std::malloc(size ? size : 1);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace weft {
namespace {

TEST(SteadyState, NoAllocationFromBatchToBatch) {
    const Graph graph = toy_graph(R"({"weft": 1, "nodes": {
        "dots": {"type": "toy-dots", "set": {"width": 96, "height": 96, "rounds": 20}},
        "odd": {"type": "toy-odd", "in": {"dots": "dots"}},
        "more": {"type": "toy-scale", "in": {"dots": "odd.odd"}},
        "merge": {"type": "toy-merge", "in": {"dots": "odd.dots", "branch": "more"}},
        "hook": {"type": "toy-batch-hook", "in": {"dots": "merge"}},
        "sum": {"type": "toy-sum", "in": {"dots": "hook"}},
        "note": {"type": "toy-note", "in": {"grid": "sum.grid"}}}})");
    std::vector<std::uint64_t> seen;
    seen.reserve(10000);
    on_hook = [&] { seen.push_back(allocations); };
    ASSERT_TRUE(run_toy(graph, *make_serial_executor()).ok());
    on_hook = nullptr;
    const size_t a_tile = 21 * 20;  // 32 x 32 pixels in batches of 50, 20 rounds
    ASSERT_EQ(seen.size(), 9 * a_tile);
    for (size_t tile = 0; tile < 9; ++tile)
        for (size_t i = tile > 0 ? 1 : 2; i < a_tile; ++i)
            EXPECT_EQ(seen[tile * a_tile + i], seen[tile * a_tile + i - 1]) << "tile " << tile << ", batch " << i;
}

}  // namespace
}  // namespace weft
