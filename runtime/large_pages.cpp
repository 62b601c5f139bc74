#include "runtime/large_pages.h"

#include <sys/mman.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <new>

namespace weft {
namespace {

size_t whole(size_t bytes) {
    if (bytes > SIZE_MAX - large_page) throw std::bad_alloc();
    return (bytes + large_page - 1) / large_page * large_page;
}

// From the system: at a multiple of large_page, on huge pages where it has them to give.
char* map_pages(size_t bytes) {
    const size_t room = whole(bytes + 1);
    void* const got =
        mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (got == MAP_FAILED) throw std::bad_alloc();
    char* const from = static_cast<char*>(got);
    const size_t before =
        (large_page - reinterpret_cast<std::uintptr_t>(from) % large_page) % large_page;
    if (before > 0) munmap(from, before);
    if (const size_t after = room - before - bytes; after > 0) munmap(from + before + bytes, after);
    madvise(from + before, bytes, MADV_HUGEPAGE);  // where it is refused, small pages do
    return from + before;
}

class FreePages {
  public:
    void* take(size_t bytes) {
        const std::lock_guard lock(mutex_);
        auto best = runs_.end();  // the shortest that is long enough
        for (auto run = runs_.begin(); run != runs_.end(); ++run)
            if (run->second >= bytes && (best == runs_.end() || run->second < best->second))
                best = run;
        if (best == runs_.end()) return map_pages(bytes);
        // Its end, so that the entry stays.
        best->second -= bytes;
        char* const found = best->first + best->second;
        if (best->second == 0) runs_.erase(best);
        return found;
    }

    void give(char* memory, size_t bytes) noexcept {
        madvise(memory, bytes, MADV_FREE);
        try {
            const std::lock_guard lock(mutex_);
            const auto next = runs_.lower_bound(memory);
            if (next != runs_.begin()) {
                const auto before = std::prev(next);
                if (before->first + before->second == memory) {
                    before->second += bytes;
                    join(before);
                    return;
                }
            }
            join(runs_.emplace_hint(next, memory, bytes));
        } catch (const std::bad_alloc&) {
            munmap(memory, bytes);
        }
    }

  private:
    using Runs = std::map<char*, size_t>;
    void join(Runs::iterator run) {
        const auto next = std::next(run);
        if (next == runs_.end() || run->first + run->second != next->first) return;
        run->second += next->second;
        runs_.erase(next);
    }

    std::mutex mutex_;
    Runs runs_;  // length by start; no two of them touch
};

// Never destroyed: arrays may outlive any order of destruction.
FreePages& free_pages() {
    static FreePages& pages = *new FreePages;
    return pages;
}

}  // namespace

void* take_large_pages(size_t bytes) {
    return free_pages().take(whole(bytes));
}

void give_large_pages(void* memory, size_t bytes) noexcept {
    free_pages().give(static_cast<char*>(memory),
                      (bytes + large_page - 1) / large_page * large_page);
}

}  // namespace weft
