#include "runtime/executor.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

namespace weft {
namespace {

int cores() { return std::max(1u, std::thread::hardware_concurrency()); }

class SerialExecutor final : public Executor {
  public:
    int threads() const override { return 1; }

    void parallel(size_t count, size_t grain, const std::function<void(size_t, size_t)>& work) override {
        for (size_t begin = 0; begin < count; begin += grain) work(begin, std::min(count, begin + grain));
    }

    void tasks(const std::function<void(const Spawn&)>& root) override {
        std::deque<std::function<void()>> queue;
        const Spawn spawn = [&](std::function<void()> task) { queue.push_back(std::move(task)); };
        root(spawn);
        while (!queue.empty()) {
            const std::function<void()> task = std::move(queue.front());
            queue.pop_front();
            task();
        }
    }
};

// One parallel loop: pieces are handed out by a counter, whoever asks. It outlives its caller's stack
// frame in helpers that come too late, hence the shared ownership.
struct Loop {
    size_t pieces, count, grain;
    const std::function<void(size_t, size_t)>* work;
    std::atomic<size_t> next = 0;
    std::mutex mutex;
    std::condition_variable done;
    size_t finished = 0;
    size_t failed_piece = SIZE_MAX;
    std::exception_ptr failure;
    std::atomic<bool> stop = false;

    void help() {
        for (;;) {
            const size_t piece = next.fetch_add(1);
            if (piece >= pieces) return;
            std::exception_ptr thrown;
            if (!stop) {
                try {
                    (*work)(piece * grain, std::min(count, (piece + 1) * grain));
                } catch (...) {
                    thrown = std::current_exception();
                    stop = true;
                }
            }
            const std::lock_guard lock(mutex);
            if (thrown && piece < failed_piece) {
                failed_piece = piece;
                failure = thrown;
            }
            if (++finished == pieces) done.notify_all();
        }
    }
};

class ThreadExecutor final : public Executor {
  public:
    explicit ThreadExecutor(int threads) : threads_(threads) {
        for (int i = 1; i < threads; ++i)
            workers_.emplace_back([this](std::stop_token stop) {
                while (std::optional<std::function<void()>> task = take(stop)) (*task)();
            });
    }

    int threads() const override { return threads_; }

    void parallel(size_t count, size_t grain, const std::function<void(size_t, size_t)>& work) override {
        const auto loop = std::make_shared<Loop>();
        loop->pieces = (count + grain - 1) / grain;
        loop->count = count;
        loop->grain = grain;
        loop->work = &work;
        const size_t helpers = std::min(loop->pieces, size_t(threads_)) - (loop->pieces > 0);
        for (size_t i = 0; i < helpers; ++i) push([loop] { loop->help(); });
        loop->help();
        std::unique_lock lock(loop->mutex);
        loop->done.wait(lock, [&] { return loop->finished == loop->pieces; });
        if (loop->failure) std::rethrow_exception(loop->failure);
    }

    void tasks(const std::function<void(const Spawn&)>& root) override {
        struct Group {
            std::mutex mutex;
            std::condition_variable idle;
            size_t open = 0;
        };
        const auto group = std::make_shared<Group>();
        const Spawn spawn = [this, group](std::function<void()> task) {
            {
                const std::lock_guard lock(group->mutex);
                ++group->open;
            }
            push([group, task = std::move(task)] {
                task();
                const std::lock_guard lock(group->mutex);
                if (--group->open == 0) group->idle.notify_all();
            });
        };
        root(spawn);
        // This thread works too, until nothing of the group is left.
        for (;;) {
            {
                const std::lock_guard lock(group->mutex);
                if (group->open == 0) return;
            }
            if (std::optional<std::function<void()>> task = try_take()) {
                (*task)();
            } else {
                std::unique_lock lock(group->mutex);
                group->idle.wait_for(lock, std::chrono::milliseconds(2), [&] { return group->open == 0; });
            }
        }
    }

  private:
    void push(std::function<void()> task) {
        {
            const std::lock_guard lock(mutex_);
            queue_.push_back(std::move(task));
        }
        ready_.notify_one();
    }
    std::optional<std::function<void()>> take(std::stop_token stop) {
        std::unique_lock lock(mutex_);
        if (!ready_.wait(lock, stop, [this] { return !queue_.empty(); })) return std::nullopt;
        return pop();
    }
    std::optional<std::function<void()>> try_take() {
        const std::lock_guard lock(mutex_);
        if (queue_.empty()) return std::nullopt;
        return pop();
    }
    std::function<void()> pop() {
        std::function<void()> task = std::move(queue_.front());
        queue_.pop_front();
        return task;
    }

    int threads_;
    std::mutex mutex_;
    std::condition_variable_any ready_;
    std::deque<std::function<void()>> queue_;
    std::vector<std::jthread> workers_;  // last: stopped and joined first
};

}  // namespace

std::unique_ptr<Executor> make_serial_executor() { return std::make_unique<SerialExecutor>(); }

std::unique_ptr<Executor> make_thread_executor(int threads) {
    return std::make_unique<ThreadExecutor>(threads > 0 ? threads : cores());
}

}  // namespace weft
