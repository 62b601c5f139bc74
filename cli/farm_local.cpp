// The local engine: shards as processes of this machine, some at a time. For tests, and for runs
// that would not fit in memory whole. Its processes end with this program.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/types.h>

#include <algorithm>
#include <csignal>
#include <deque>
#include <thread>

#include "cli/farm_engine.h"
#include "cli/process.h"

namespace weft::cli {
namespace {

class LocalEngine final : public FarmEngine {
  public:
    explicit LocalEngine(const EngineOptions& options) : at_once_(std::max(options.at_once, 1)) {}
    ~LocalEngine() override { stop(); }

    void expect_idle(const FarmJob&) override {}

    void submit(const FarmJob& job, const std::vector<int>& shards) override {
        waiting_.assign(shards.begin(), shards.end());
        for (const int shard : shards) states_[shard] = {};
        states_[0] = {};
        merge_ = true;
        poll(job);
    }

    FarmStates poll(const FarmJob& job) override {
        for (auto process = running_.begin(); process != running_.end();) {
            const int status = poll_process(process->second);
            if (status < 0) {
                ++process;
                continue;
            }
            const int shard = process->first;
            process = running_.erase(process);
            // Killed, by hand or for want of memory: it is tried again, as a farm would.
            if (status == 128 + SIGKILL && ++killed_[shard] <= most_kills)
                waiting_.push_front(shard);
            else
                states_[shard] = {FarmState::ended,
                                  status > 128 ? fmt::format("ended by signal {}", status - 128)
                                               : fmt::format("exit status {}", status)};
        }
        while (!waiting_.empty() && running_.size() < size_t(at_once_)) {
            start(job, waiting_.front());
            waiting_.pop_front();
        }
        if (merge_ && running_.empty() && waiting_.empty()) {
            merge_ = false;
            bool all = true;
            for (int i = 1; i <= job.shards(); ++i) all = all && job.has_part(i);
            if (all) start(job, 0);
        }
        return states_;
    }

    void cancel_merge(const FarmJob&) override {
        merge_ = false;
        states_.erase(0);
    }

    std::vector<std::string> commands(const FarmJob& job,
                                      const std::vector<int>& shards) const override {
        std::vector<std::string> all;
        for (const int shard : shards)
            all.push_back(fmt::format("{}", fmt::join(arguments(job, shard), " ")));
        all.push_back(fmt::format("{}", fmt::join(arguments(job, 0), " ")));
        return all;
    }

    std::string leave(const FarmJob&) override {
        stop();
        return "the shards that ran here were stopped; those that are done stay";
    }

  private:
    static constexpr int most_kills = 2;

    std::vector<std::string> arguments(const FarmJob& job, int shard) const {
        const int cores = int(std::max(1u, std::thread::hardware_concurrency()));
        const int threads = job.threads > 0 ? job.threads
                            : shard == 0    ? cores
                                            : std::max(1, cores / at_once_);
        return {"/bin/sh", job.script(), shard == 0 ? "merge" : std::to_string(shard),
                std::to_string(threads)};
    }

    void start(const FarmJob& job, int shard) {
        running_[shard] = start_process(arguments(job, shard), job.log(shard));
        states_[shard] = {FarmState::running, ""};
    }

    void stop() {
        waiting_.clear();
        merge_ = false;
        for (const auto& [shard, pid] : running_) ::kill(-pid, SIGTERM);
        for (const auto& [shard, pid] : running_)
            for (int i = 0; i < 100 && poll_process(pid) < 0; ++i) {
                if (i == 50) ::kill(-pid, SIGKILL);
                std::this_thread::sleep_for(std::chrono::milliseconds(100));
            }
        running_.clear();
    }

    int at_once_;
    std::deque<int> waiting_;
    std::map<int, pid_t> running_;
    std::map<int, int> killed_;
    FarmStates states_;
    bool merge_ = false;  // still to be started
};

}  // namespace

std::unique_ptr<FarmEngine> make_local_engine(const EngineOptions& options) {
    return std::make_unique<LocalEngine>(options);
}

}  // namespace weft::cli
