#include "runtime/node_context.h"

#include <set>

namespace weft {
namespace {

// Time of this thread that belongs to somebody else: while a loop waits, its thread may run pieces
// of other loops, and its own pieces are counted by themselves.
thread_local std::uint64_t elsewhere_ns = 0;

class OwnTime {
  public:
    OwnTime() : begin_(thread_cpu_ns()), elsewhere_(elsewhere_ns) {}
    std::uint64_t ns() const { return thread_cpu_ns() - begin_ - (elsewhere_ns - elsewhere_); }
    // Everything since the start is accounted for: nobody around counts it again.
    void close() { elsewhere_ns = elsewhere_ + (thread_cpu_ns() - begin_); }

  private:
    std::uint64_t begin_, elsewhere_;
};

// Units are shown by another thread for as long as the process runs.
const char* kept(std::string_view text) {
    static std::mutex mutex;
    static std::set<std::string, std::less<>> texts;
    const std::lock_guard lock(mutex);
    return texts.emplace(text).first->c_str();
}

}  // namespace

void NodeContext::parallel(size_t count, size_t grain, const std::function<void(size_t, size_t)>& work) {
    OwnTime waiting;
    executor_.parallel(count, std::max<size_t>(grain, 1), [&](size_t begin, size_t end) {
        check_cancelled();
        OwnTime time;
        work(begin, end);
        pieces_ns_ += time.ns();
        time.close();
    });
    waiting.close();
}

void NodeContext::progress(double done, double total, std::string_view unit) {
    progress_.finished = done;
    progress_.total = total;
    if (unit != progress_.unit.load()) progress_.unit = kept(unit);
}

double NodeContext::timed(const std::function<void()>& work) {
    pieces_ns_ = 0;
    OwnTime time;
    work();
    const std::uint64_t own = time.ns();
    time.close();
    return double(own + pieces_ns_) * 1e-9;
}

}  // namespace weft
