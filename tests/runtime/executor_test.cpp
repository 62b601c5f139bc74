// Executors: three forms, one contract.
#include "runtime/executor.h"

#include <gtest/gtest.h>

#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace weft {
namespace {

struct Form {
    std::string name;
    std::function<std::unique_ptr<Executor>()> make;
};

class Executors : public testing::TestWithParam<Form> {};

TEST_P(Executors, EveryIndexIsVisitedOnceInPiecesThatDependOnTheWorkAlone) {
    const auto executor = GetParam().make();
    for (size_t count : {0, 1, 7, 64, 1000})
        for (size_t grain : {1, 3, 64}) {
            std::mutex mutex;
            std::multiset<size_t> seen;
            std::set<size_t> begins;
            executor->parallel(count, grain, [&](size_t begin, size_t end) {
                const std::lock_guard lock(mutex);
                begins.insert(begin);
                for (size_t i = begin; i < end; ++i) seen.insert(i);
            });
            ASSERT_EQ(seen.size(), count);
            ASSERT_EQ(std::set<size_t>(seen.begin(), seen.end()).size(), count);
            for (size_t begin : begins) ASSERT_EQ(begin % grain, 0u);
        }
}

TEST_P(Executors, NestedLoopsEnd) {
    const auto executor = GetParam().make();
    std::atomic<int> count = 0;
    executor->parallel(20, 1, [&](size_t, size_t) {
        executor->parallel(20, 3, [&](size_t begin, size_t end) {
            executor->parallel(end - begin, 1, [&](size_t, size_t) { ++count; });
        });
    });
    EXPECT_EQ(count, 400);
}

TEST_P(Executors, AThrowingPieceEndsTheLoopWithItsException) {
    const auto executor = GetParam().make();
    try {
        executor->parallel(1000, 1, [&](size_t i, size_t) {
            if (i >= 500) throw std::runtime_error("piece " + std::to_string(i));
        });
        FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
        EXPECT_EQ(std::string(error.what()).rfind("piece ", 0), 0u);
    }
    std::atomic<int> after = 0;  // it can be used again
    executor->parallel(10, 1, [&](size_t, size_t) { ++after; });
    EXPECT_EQ(after, 10);
}

TEST_P(Executors, TasksMaySpawnTasksAndLoops) {
    const auto executor = GetParam().make();
    std::atomic<int> done = 0;
    executor->tasks([&](const Executor::Spawn& spawn) {
        for (int i = 0; i < 10; ++i)
            spawn([&, i] {
                executor->parallel(10, 1, [&](size_t, size_t) { ++done; });
                if (i < 5) spawn([&] { done += 100; });
            });
    });
    EXPECT_EQ(done, 600);
}

std::vector<Form> forms() {
    std::vector<Form> all = {
        {"serial", [] { return make_serial_executor(); }},
        {"threads1", [] { return make_thread_executor(1); }},
        {"threads2", [] { return make_thread_executor(2); }},
        {"threads7", [] { return make_thread_executor(7); }},
    };
#ifndef __SANITIZE_THREAD__  // ThreadSanitizer does not see into oneTBB; the other forms stand for it there
    for (int n : {1, 2, 7}) all.push_back({"tbb" + std::to_string(n), [n] { return make_tbb_executor(n); }});
#endif
    return all;
}

INSTANTIATE_TEST_SUITE_P(All, Executors, testing::ValuesIn(forms()), [](const auto& form) { return form.param.name; });

}  // namespace
}  // namespace weft
