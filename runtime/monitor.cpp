#include "runtime/monitor.h"

#include <fmt/format.h>

#include <ctime>
#include <set>

#include "runtime/plan.h"

namespace weft {

std::uint64_t now_us() {
    static const auto start = std::chrono::steady_clock::now();
    return std::uint64_t(
        std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - start).count());
}

std::uint64_t thread_cpu_ns() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return std::uint64_t(now.tv_sec) * 1000000000u + std::uint64_t(now.tv_nsec);
}

int thread_number() {
    static std::atomic<int> next = 0;
    thread_local const int number = next++;
    return number;
}

void Monitor::begin(const Plan& plan) {
    tasks.clear();
    for (const Task& task : plan.tasks) tasks.emplace_back().name = task.name;
}

void Monitor::span(Span span) {
    if (!tracing) return;
    const std::lock_guard lock(mutex_);
    spans_.push_back(std::move(span));
}

void Monitor::warn(const std::string& node, const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (warning) warning(node, message);
}

std::string Monitor::trace() const {
    const std::lock_guard lock(mutex_);
    std::string text = "{\"traceEvents\":[";
    const char* comma = "\n";
    std::set<int> threads;
    for (const Span& span : spans_) {
        threads.insert(span.thread);
        text += fmt::format("{}{{\"name\":{},\"cat\":{},\"ph\":\"X\",\"ts\":{},\"dur\":{},\"pid\":1,\"tid\":{}{}}}", comma,
                            Json(span.name).dump(), Json(span.category).dump(), span.begin_us, span.duration_us, span.thread,
                            span.args.empty() ? "" : ",\"args\":" + span.args);
        comma = ",\n";
    }
    for (int thread : threads) {
        text += fmt::format("{}{{\"name\":\"thread_name\",\"ph\":\"M\",\"pid\":1,\"tid\":{},\"args\":{{\"name\":\"{}\"}}}}", comma,
                            thread, thread == 0 ? std::string("main") : fmt::format("worker {}", thread));
        comma = ",\n";
    }
    return text + "\n]}\n";
}

}  // namespace weft
