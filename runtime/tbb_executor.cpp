#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <mutex>
#include <thread>

#include "runtime/executor.h"

namespace weft {
namespace {

class TbbExecutor final : public Executor {
  public:
    explicit TbbExecutor(int threads)
        : threads_(threads),
          limit_(tbb::global_control::max_allowed_parallelism, size_t(threads)),
          arena_(threads) {}

    int threads() const override { return threads_; }

    void parallel(size_t count, size_t grain, const std::function<void(size_t, size_t)>& work) override {
        const size_t pieces = (count + grain - 1) / grain;
        std::mutex mutex;
        size_t failed_piece = SIZE_MAX;
        std::exception_ptr failure;
        std::atomic<bool> stop = false;
        const auto piece_work = [&](size_t piece) {
            if (stop) return;
            try {
                work(piece * grain, std::min(count, (piece + 1) * grain));
            } catch (...) {
                stop = true;
                const std::lock_guard lock(mutex);
                if (piece < failed_piece) {
                    failed_piece = piece;
                    failure = std::current_exception();
                }
            }
        };
        arena_.execute([&] { tbb::parallel_for(size_t{0}, pieces, piece_work, tbb::simple_partitioner()); });
        if (failure) std::rethrow_exception(failure);
    }

    void tasks(const std::function<void(const Spawn&)>& root) override {
        arena_.execute([&] {
            tbb::task_group group;
            const Spawn spawn = [&](std::function<void()> task) { group.run(std::move(task)); };
            root(spawn);
            group.wait();
        });
    }

  private:
    int threads_;
    tbb::global_control limit_;  // libraries under us that use TBB stay within it
    tbb::task_arena arena_;
};

}  // namespace

std::unique_ptr<Executor> make_tbb_executor(int threads) {
    return std::make_unique<TbbExecutor>(threads > 0 ? threads
                                                     : int(std::max(1u, std::thread::hardware_concurrency())));
}

}  // namespace weft
