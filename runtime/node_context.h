// NodeContext: the Context of a node of a running plan. Counts the CPU time of its loops' pieces,
// whatever thread runs them.
#pragma once
#include <atomic>

#include "runtime/executor.h"
#include "runtime/monitor.h"
#include "runtime/run.h"

namespace weft {

class NodeContext final : public Context {
  public:
    NodeContext(std::string node, Executor& executor, Monitor& monitor, TaskProgress& progress, const RunOptions& options)
        : node_(std::move(node)), executor_(executor), monitor_(monitor), progress_(progress), options_(options) {}

    // Whose warnings follow: a segment has several nodes.
    void speak_for(const std::string& node) { node_ = node; }
    void warn(const std::string& message) override { monitor_.warn(node_, message); }
    bool cancelled() const override { return options_.stop && *options_.stop; }
    void parallel(size_t count, size_t grain, const std::function<void(size_t, size_t)>& work) override;
    void progress(double done, double total, std::string_view unit) override;
    const Provenance& provenance() const override { return options_.provenance; }

    // CPU seconds of `work` on this thread and of all pieces of its loops.
    double timed(const std::function<void()>& work);

  private:
    std::string node_;
    Executor& executor_;
    Monitor& monitor_;
    TaskProgress& progress_;
    const RunOptions& options_;
    std::atomic<std::uint64_t> pieces_ns_ = 0;
};

}  // namespace weft
