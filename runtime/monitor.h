// Monitor: how far a run is, for whoever looks on while it runs (the terminal), and what it took, for
// the report and the trace. Counters are atomic; anybody may read them at any time.
#pragma once
#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "graph/json.h"

namespace weft {

struct Plan;

// Microseconds of this process.
std::uint64_t now_us();
// CPU nanoseconds of this thread.
std::uint64_t thread_cpu_ns();
// A small number for the calling thread, from 0.
int thread_number();

struct TaskProgress {
    enum State { waiting, running, done, failed, skipped };
    std::string name;
    std::atomic<int> state = waiting;
    std::atomic<double> finished = 0, total = 0;
    std::atomic<const char*> unit = "";      // a literal, or a string that lives as long as the process
    std::atomic<std::uint64_t> started_us = 0, ended_us = 0;
};

struct Span {
    std::string name, category;
    std::uint64_t begin_us, duration_us;
    int thread;
    std::string args;  // JSON object, or ""
};

class Monitor {
  public:
    std::deque<TaskProgress> tasks;                           // as the plan's
    std::function<void(const std::string& node, const std::string& message)> warning;  // may be null; called under a lock
    bool tracing = false;

    void begin(const Plan& plan);
    void span(Span span);
    void warn(const std::string& node, const std::string& message);

    // Chrome trace events (Perfetto, chrome://tracing), one JSON text.
    std::string trace() const;

  private:
    mutable std::mutex mutex_;
    std::vector<Span> spans_;
};

}  // namespace weft
