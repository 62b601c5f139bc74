// FarmEngine: who runs a farm's shards. It starts run.sh for each, says what became of them, and
// starts the merge once all are done. Whether a shard is done is told by its part, never by the
// engine.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cli/farm_job.h"

namespace weft::cli {

struct FarmState {
    enum What { waiting, running, ended };
    What what = waiting;
    std::string word;  // the engine's own for it, "TIMEOUT", "exit status 1"; for messages
};
using FarmStates =
    std::map<int, FarmState>;  // by shard; 0: the merge. Not there: never submitted, or long gone

class FarmEngine {
  public:
    virtual ~FarmEngine() = default;
    // Throws Error if the engine cannot be used here, or is busy with this very job.
    virtual void expect_idle(const FarmJob& job) = 0;
    virtual void submit(const FarmJob& job, const std::vector<int>& shards) = 0;
    virtual FarmStates poll(const FarmJob& job) = 0;
    // A shard failed: the merge must not wait for ever.
    virtual void cancel_merge(const FarmJob& job) = 0;
    // What submit() would run, a line each.
    virtual std::vector<std::string> commands(const FarmJob& job,
                                              const std::vector<int>& shards) const = 0;
    // Ctrl-C came: either jobs go on without us, or they are ended here. Returns what to tell.
    virtual std::string leave(const FarmJob& job) = 0;
};

struct EngineOptions {
    std::string partition;               // Slurm's
    std::vector<std::string> arguments;  // to sbatch
    int at_once = 0;                     // local: shards at a time; 0: 1
};
std::unique_ptr<FarmEngine> make_local_engine(const EngineOptions& options);
std::unique_ptr<FarmEngine> make_slurm_engine(const EngineOptions& options);

}  // namespace weft::cli
