// Context: what a running node may ask of the runtime: loops, progress, warnings, cancellation.
#pragma once
#include <algorithm>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "graph/error.h"

namespace weft {

// What written files say of the run that made them (docs/provenance.md).
struct Provenance {
    std::string graph;    // the flattened document, JSON
    std::string inputs;   // [{"path", "size", "xxh3"}], JSON
    std::string version;  // of the program
};

struct Rows {
    int begin, end;
};

class Context {
  public:
    virtual ~Context() = default;

    // Ends the node with this message; the runtime adds its name and its place in the document.
    [[noreturn]] void fail(const std::string& message) const { throw Error(message); }
    // A finding that does not end the node, shown once the run goes on.
    virtual void warn(const std::string& message) = 0;

    virtual bool cancelled() const = 0;
    void check_cancelled() const {
        if (cancelled()) throw Cancelled();
    }

    // work(begin, end) over [0, count) in pieces of at most `grain`; pieces do not depend on the
    // number of threads. Nested loops are safe. Cancellation is looked at between pieces.
    virtual void parallel(size_t count, size_t grain,
                          const std::function<void(size_t begin, size_t end)>& work) = 0;

    template <class Work>
    void parallel_for(size_t count, Work&& work, size_t grain = 1) {
        parallel(count, grain, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) work(i);
        });
    }
    template <class Work>
    void parallel_rows(int height, Work&& work, int grain = 8) {
        parallel(size_t(std::max(height, 0)), size_t(grain),
                 [&](size_t begin, size_t end) { work(Rows{int(begin), int(end)}); });
    }
    // Joins map(begin, end) of fixed pieces in index order: the same bits for any number of threads.
    template <class T, class Map, class Join>
    T reduce(size_t count, size_t grain, T start, Map&& map, Join&& join) {
        std::vector<T> parts((count + grain - 1) / grain, start);
        parallel(count, grain, [&](size_t begin, size_t end) { parts[begin / grain] = map(begin, end); });
        for (const T& part : parts) start = join(start, part);
        return start;
    }

    // `done` of `total` units ("samples", "rows"); cheap, call as often as you like.
    virtual void progress(double done, double total, std::string_view unit) = 0;

    virtual const Provenance& provenance() const = 0;
};

// Runs everything on the calling thread and keeps the warnings: for tests and small tools.
class PlainContext : public Context {
  public:
    void warn(const std::string& message) override { warnings.push_back(message); }
    bool cancelled() const override { return stop; }
    void parallel(size_t count, size_t grain, const std::function<void(size_t, size_t)>& work) override {
        for (size_t begin = 0; begin < count; begin += grain) {
            check_cancelled();
            work(begin, std::min(count, begin + grain));
        }
    }
    void progress(double, double, std::string_view) override {}
    const Provenance& provenance() const override { return written; }

    std::vector<std::string> warnings;
    Provenance written;
    bool stop = false;
};

}  // namespace weft
