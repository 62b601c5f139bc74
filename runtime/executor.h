// Executor: where work runs. Three forms with one contract: oneTBB (the usual one: a work-stealing
// pool that nested loops and Embree share), std::jthread (small, and visible to ThreadSanitizer),
// and serial (everything on the calling thread, in order: for the debugger).
#pragma once
#include <atomic>
#include <functional>
#include <memory>

namespace weft {

class Executor {
  public:
    virtual ~Executor() = default;
    virtual int threads() const = 0;

    // work(begin, end) over [0, count) in pieces of `grain`, on this and other threads; returns when
    // all are done. Pieces depend on count and grain alone. May be nested. A piece that throws ends the
    // loop: no further piece starts, and the exception of the lowest piece that threw is thrown here.
    virtual void parallel(size_t count, size_t grain,
                          const std::function<void(size_t begin, size_t end)>& work) = 0;

    // Runs root(spawn) and everything that it spawns, directly or not; returns when all are done.
    // Tasks must not throw.
    using Spawn = std::function<void(std::function<void()>)>;
    virtual void tasks(const std::function<void(const Spawn&)>& root) = 0;
};

// threads: 0 for one a core.
std::unique_ptr<Executor> make_tbb_executor(int threads);
std::unique_ptr<Executor> make_thread_executor(int threads);
std::unique_ptr<Executor> make_serial_executor();

}  // namespace weft
