// Memory of large arrays: whole pages, no two holders of one, and none is asked of the system that
// was given back.
#include "runtime/large_pages.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <thread>
#include <vector>

#include "runtime/large_array.h"

namespace weft {
namespace {

constexpr size_t page = large_page;

// Address space of the process, in bytes: what the system was asked for.
size_t mapped() {
    size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * 4096;
}

TEST(LargePages, StartAtAPage) {
    for (const size_t bytes : {size_t(1), page - 1, page, page + 1, 5 * page}) {
        void* const at = take_large_pages(bytes);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(at) % page, 0u) << bytes;
        std::memset(at, 1, bytes);
        give_large_pages(at, bytes);
    }
}

TEST(LargePages, AreTakenAgain) {
    void* const first = take_large_pages(64 * page);
    give_large_pages(first, 64 * page);
    const size_t before = mapped();
    void* const second = take_large_pages(64 * page);
    EXPECT_EQ(second, first);
    EXPECT_EQ(mapped(), before);
    give_large_pages(second, 64 * page);
}

TEST(LargePages, ManySmallTakeTheRoomOfALargeOneAndBack) {
    void* const row = take_large_pages(100 * page);
    give_large_pages(row, 100 * page);
    const size_t before = mapped();
    std::vector<void*> parts;
    for (int k = 0; k < 100; ++k) parts.push_back(take_large_pages(page));
    EXPECT_EQ(mapped(), before);
    // In whatever order they are given back, they are one again.
    for (size_t k = 0; k < parts.size(); ++k) give_large_pages(parts[k * 37 % parts.size()], page);
    give_large_pages(take_large_pages(100 * page), 100 * page);
    EXPECT_EQ(mapped(), before);
}

TEST(LargePages, TheShortestRunThatIsLongEnoughIsTaken) {
    char* const row = static_cast<char*>(take_large_pages(200 * page));
    // 150 pages and 20, with ten held between them.
    give_large_pages(row, 150 * page);
    give_large_pages(row + 160 * page, 20 * page);
    char* const small = static_cast<char*>(take_large_pages(20 * page));
    EXPECT_EQ(small, row + 160 * page);
    give_large_pages(small, 20 * page);
    give_large_pages(row + 150 * page, 10 * page);
    give_large_pages(row + 180 * page, 20 * page);
}

TEST(LargePages, TooMuchIsRefused) {
    EXPECT_THROW(take_large_pages(SIZE_MAX), std::bad_alloc);
    EXPECT_THROW(take_large_pages(SIZE_MAX / 2), std::bad_alloc);
}

TEST(LargePages, NoTwoThreadsHoldOne) {
    const auto work = [](unsigned char mark) {
        for (size_t round = 0; round < 200; ++round) {
            const size_t bytes = (1 + (round * 7 + mark) % 5) * page;
            auto* const at = static_cast<unsigned char*>(take_large_pages(bytes));
            for (size_t i = 0; i < bytes; i += page / 4) at[i] = mark;
            for (size_t i = 0; i < bytes; i += page / 4) ASSERT_EQ(at[i], mark);
            give_large_pages(at, bytes);
        }
    };
    std::vector<std::thread> threads;
    for (unsigned char k = 1; k <= 4; ++k) threads.emplace_back(work, k);
    for (std::thread& thread : threads) thread.join();
}

TEST(LargeArray, KeepsWhatIsWrittenAsItGrows) {
    LargeArray<std::uint32_t> values(3);
    for (std::uint32_t i = 0; i < 3; ++i) values[i] = i;
    for (std::uint32_t i = 3; i < 2000000; ++i) values.push_back(i);
    for (std::uint32_t i = 0; i < 2000000; ++i) ASSERT_EQ(values[i], i);
}

}  // namespace
}  // namespace weft
